//! Reports: measurements as HTML pages, as Markdown for the terminal, as JSON and as CSV. [`page`], [`chart`], [`plot`]
//! and [`table`] do not depend on the reported data.

pub mod battery;
pub mod bench;
pub mod chart;
pub mod compare;
pub mod false_colour;
pub mod lesson;
pub mod measurement;
pub mod page;
pub mod plot;
pub mod price;
pub mod prose;
pub mod study;
pub mod table;
