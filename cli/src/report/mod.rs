//! Reports: measurements as pages of HTML, as Markdown for the terminal, as JSON and as CSV. [`page`], [`chart`], [`plot`] and
//! [`table`] know nothing of what is reported.

pub mod battery;
pub mod bench;
pub mod chart;
pub mod compare;
pub mod false_colour;
pub mod keeper;
pub mod lesson;
pub mod page;
pub mod plot;
pub mod prose;
pub mod study;
pub mod table;
