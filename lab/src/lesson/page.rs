//! What a lesson consists of, as data: how it looks is for whoever shows it.
//!
//! Measure: said at each field.
//! Range: any numbers. In a text, backticks stand around code; a formula is LaTeX.
//! Source: none needed. Tested in `lab/tests/reports/lesson.rs`.

use super::number::{Number, Technique};
use crate::plot::Plot;
use etendue::internals::image::Image;
use serde::{Serialize, Serializer};

/// A lesson: what it claims, and what was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Page {
    /// What the lesson claims.
    pub claim: String,
    /// The claim as formulas.
    pub formulas: Vec<Formula>,
    /// What was done to see whether it holds.
    pub experiment: String,
    /// What came out, in the order of reading.
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

/// A formula, with what it says in words.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Formula {
    /// In the notation of LaTeX.
    pub latex: String,
    /// What it says.
    pub says: String,
}

impl Formula {
    /// A formula, with what it says. Where its lines break does not matter.
    pub fn new(latex: &str, says: impl Into<String>) -> Self {
        let words: Vec<&str> = latex.split_whitespace().collect();
        Self {
            latex: words.join(" "),
            says: says.into(),
        }
    }
}

/// A part of what came out.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Finding {
    /// Numbers beside their exact values.
    Numbers {
        /// How to read them.
        reading: String,
        /// The numbers.
        numbers: Vec<Number>,
    },
    /// Ways to estimate the same, with their efficiencies.
    Techniques {
        /// How to read them.
        reading: String,
        /// The ways, of which the first is what others are held against.
        techniques: Vec<Technique>,
    },
    /// Plots that belong side by side.
    Plots {
        /// The plots.
        plots: Vec<Plot>,
    },
    /// Pictures that belong side by side.
    Pictures {
        /// What they are.
        title: String,
        /// How to read them.
        reading: String,
        /// The pictures.
        pictures: Vec<Picture>,
    },
}

/// A picture with its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Picture {
    /// What it shows.
    pub name: String,
    /// What to know of it, such as its samples and its error.
    pub says: String,
    /// The picture itself; in data only its size.
    #[serde(serialize_with = "size")]
    pub image: Image,
}

fn size<S: Serializer>(image: &Image, serializer: S) -> Result<S::Ok, S::Error> {
    [image.width(), image.height()].serialize(serializer)
}
