//! A report as a self-contained HTML page, without external scripts, fonts or styles.
//!
//! Measure: none.
//! Range: any browser with CSS grid; light and dark colour schemes, phones and print.
//! Source: HTML Living Standard. Tested in `cli/tests/command/bench.rs`.

use super::prose::prose;
use super::{chart, plot};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use etendue::internals::image::{Image, png_bytes};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Builds a page with its title.
pub fn page(title: &str, body: &Markup) -> String {
    styled_page(title, "", body)
}

/// Builds a page with its title and additional styles.
pub fn styled_page(title: &str, style: &str, body: &Markup) -> String {
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(chart::STYLE)) (PreEscaped(plot::STYLE)) (PreEscaped(style)) }
            }
            body { main { (body) } }
        }
    };
    markup.into_string()
}

/// Embeds an image with its name and its caption; it belongs in a `div.figures`.
pub fn figure(name: &str, caption: &str, image: &Image) -> Markup {
    let png = STANDARD.encode(png_bytes(image, 0.0));
    html! {
        figure.figure {
            img alt=(name) width=(image.width()) height=(image.height()) src={ "data:image/png;base64," (png) };
            figcaption { strong { (prose(name)) } br; (prose(caption)) }
        }
    }
}

/// The style sheet of all pages.
pub const STYLE: &str = "
:root { color-scheme: light dark; --ground: #fff; --text: #1c2026; --faint: #59616b; --line: #d4d8dd; --track: #eef0f2;
  --hue-0: #0072b2; --hue-1: #d55e00; --hue-2: #009e73; --hue-3: #cc79a7; --hue-4: #e69f00; --hue-5: #56b4e9;
  --hue-6: #8a9099; }
@media (prefers-color-scheme: dark) { :root { --ground: #15181c; --text: #e6e8ea; --faint: #a0a8b1; --line: #3a4047;
  --track: #23282e; --hue-0: #3d9ad6; --hue-1: #ee7a2e; --hue-2: #27b88d; --hue-3: #d98fb8; --hue-4: #ecb13c;
  --hue-5: #85cdf5; --hue-6: #7b828b; } }
@media print { :root { --ground: #fff; --text: #000; --faint: #444; --line: #bbb; --track: #eee; } }
body { margin: 0; background: var(--ground); color: var(--text); font: 1rem/1.5 system-ui, sans-serif; }
main { max-width: 62rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.8rem; line-height: 1.2; } h2 { font-size: 1.4rem; margin-top: 2.5rem;
  border-top: 1px solid var(--line); padding-top: 1rem; } h3 { font-size: 1.1rem; margin: 1.6rem 0 .3rem; }
h1, h2, h3 { break-after: avoid; } p { margin: .4rem 0; } section { break-inside: auto; }
.headline { font-size: 1.25rem; font-weight: 600; margin: .3rem 0; padding: 0; list-style: none; }
.caption { color: var(--faint); max-width: 48rem; }
.warning { border-left: 4px solid var(--hue-1); padding-left: .75rem; }
nav a { margin-right: 1rem; } a { color: var(--hue-0); }
code { font: .9em ui-monospace, monospace; overflow-wrap: anywhere; }
.table { overflow-x: auto; margin: .6rem 0; }
table { border-collapse: collapse; font-size: .9rem; }
th, td { padding: .2rem .75rem .2rem 0; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
th { color: var(--faint); font-weight: 600; white-space: nowrap; }
.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 14rem), 1fr)); gap: 1rem; margin: .8rem 0; }
.figure { margin: 0; break-inside: avoid; font-size: .9rem; font-variant-numeric: tabular-nums; }
.figure img { display: block; width: 100%; height: auto; image-rendering: pixelated; margin-bottom: .3rem; }
tr { break-inside: avoid; } summary { cursor: pointer; color: var(--faint); }
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prose_escapes_html_and_marks_up_code() {
        assert_eq!(
            prose("a `b` <c>").into_string(),
            "a <code>b</code> &lt;c&gt;"
        );
    }
}
