//! Texts within HTML pages.
//!
//! Measure: none.
//! Range: any text; it is escaped.
//! Source: none needed. Tested through every page.

use maud::{Markup, html};

/// Converts a text to HTML; `backticks` mark code.
pub fn prose(text: &str) -> Markup {
    html! {
        @for (index, piece) in text.split('`').enumerate() {
            @if index % 2 == 1 { code { (piece) } } @else { (piece) }
        }
    }
}
