//! A lesson for the terminal: its key numbers, as Markdown.
//!
//! Measure: that of the numbers.
//! Range: any page. Plots and images are only in the HTML page.
//! Source: none needed. Tested in `cli/tests/command/lesson.rs`.

use super::wording::{number_table, technique_table};
use etendue_lab::lesson::TOPICS;
use etendue_lab::lesson::page::{Finding, Page};
use etendue_lab::lesson::topic::Topic;

/// Returns the table of contents.
pub fn contents() -> String {
    let width = TOPICS
        .iter()
        .map(|topic| topic.name.len())
        .max()
        .unwrap_or(0);
    let line = |topic: &Topic| format!("  {:<width$}  {}\n", topic.name, topic.summary);
    let lines: String = TOPICS.iter().map(line).collect();
    format!(
        "The course on Monte Carlo integration:\n\n{lines}\n\
         `etendue lesson TOPIC` shows one, `etendue lesson --all` makes a page of each.\n"
    )
}

/// Returns the numbers of a topic.
pub fn of_page(topic: &Topic, page: &Page) -> String {
    let findings = page.findings.iter().map(|finding| match finding {
        Finding::Numbers { reading, numbers } => number_table(reading, numbers).markdown(2),
        Finding::Techniques {
            reading,
            techniques,
        } => technique_table(reading, techniques).markdown(2),
        Finding::Plots { .. } | Finding::Figures { .. } => String::new(),
    });
    let findings: String = findings.collect();
    format!("# {}\n\n{}\n\n{findings}", topic.title, page.claim)
}
