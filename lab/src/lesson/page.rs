//! The contents of a lesson, as data: their appearance is left to the code that shows them.
//!
//! Measure: stated at each field.
//! Range: any numbers. In a text, backticks enclose code; a formula is LaTeX.
//! Source: none needed. Tested in `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use crate::plot::Plot;
use etendue::internals::image::Image;
use serde::{Serialize, Serializer};

/// A lesson: its claim, and its findings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Page {
    /// The claim of the lesson.
    pub claim: String,
    /// The claim as formulas.
    pub formulas: Vec<Formula>,
    /// A description of the experiment that tests the claim.
    pub experiment: String,
    /// The results, in reading order.
    pub findings: Vec<Finding>,
}

impl Page {
    /// All numbers with their verdicts.
    pub fn numbers(&self) -> impl Iterator<Item = &Number> {
        self.findings.iter().flat_map(|finding| match finding {
            Finding::Numbers { numbers, .. } => numbers.as_slice(),
            _ => &[],
        })
    }
}

/// A formula with an explanation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Formula {
    /// The formula in LaTeX.
    pub latex: String,
    /// The explanation.
    pub caption: String,
}

impl Formula {
    /// A formula with its explanation. Line breaks in the formula do not matter.
    pub fn new(latex: &str, caption: impl Into<String>) -> Self {
        let words: Vec<&str> = latex.split_whitespace().collect();
        Self {
            latex: words.join(" "),
            caption: caption.into(),
        }
    }
}

/// A part of the results.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Finding {
    /// Numbers with their exact values.
    Numbers {
        /// Text on how to read them.
        reading: String,
        /// The numbers.
        numbers: Vec<Number>,
    },
    /// Estimators of the same quantity, with their efficiencies.
    Techniques {
        /// Text on how to read them.
        reading: String,
        /// The estimators; the others are compared with the first.
        techniques: Vec<MeasuredTechnique>,
    },
    /// Plots to be shown side by side.
    Plots {
        /// The plots.
        plots: Vec<Plot>,
    },
    /// Images to be shown side by side.
    Figures {
        /// The title.
        title: String,
        /// Text on how to read them.
        reading: String,
        /// The images.
        figures: Vec<Figure>,
    },
}

/// An image with its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// The name of the image.
    pub name: String,
    /// A description, such as its number of samples and its error.
    pub caption: String,
    /// The image itself; serialised as its size only.
    #[serde(serialize_with = "size")]
    pub image: Image,
}

fn size<S: Serializer>(image: &Image, serializer: S) -> Result<S::Ok, S::Error> {
    [image.width(), image.height()].serialize(serializer)
}
