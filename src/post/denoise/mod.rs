//! Noise filters: the picture, less its noise, and how wrong it is then.
//!
//! Measure: linear radiance; errors as roots of relMSE.
//! Range: a picture with its first half, standard errors and first hits. Filtered pictures are biased; the bias of the
//! filter by non-local means vanishes as the noise does, that of a trained network does not.
//! Source: the files here. Tested in `tests/rendering/denoise.rs`.

mod choice;
mod guides;
mod means;
mod noisy;
mod own;
mod part;
mod prefilter;
#[cfg(feature = "oidn")]
mod trained;

pub use noisy::Noisy;

use crate::error::Result;
use crate::image::Image;

/// The filters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Denoiser {
    /// Non-local means over the halves of the picture, guided by first hits.
    NonLocalMeans,
    /// Intel's Open Image Denoise, where it is found.
    #[cfg(feature = "oidn")]
    OpenImageDenoise,
}

impl Denoiser {
    /// Those of this build.
    pub const ALL: &'static [Self] = &[
        Self::NonLocalMeans,
        #[cfg(feature = "oidn")]
        Self::OpenImageDenoise,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::NonLocalMeans => "nlm",
            #[cfg(feature = "oidn")]
            Self::OpenImageDenoise => "oidn",
        }
    }

    /// What biases the picture, in words.
    pub fn bias(self) -> &'static str {
        match self {
            Self::NonLocalMeans => {
                "denoise nlm: neighbouring pixels are mixed, less so the less noise there is"
            }
            #[cfg(feature = "oidn")]
            Self::OpenImageDenoise => "denoise oidn: a trained network made this picture",
        }
    }

    /// Whether it is there: known before a render spends its hours.
    ///
    /// # Errors
    /// If a library is not found.
    pub fn check(self) -> Result<()> {
        match self {
            Self::NonLocalMeans => Ok(()),
            #[cfg(feature = "oidn")]
            Self::OpenImageDenoise => crate::post::oidn::check(),
        }
    }

    /// Filters a picture. The same bits come out for any number of threads.
    ///
    /// # Errors
    /// If a library is not found, or fails.
    pub fn filter(self, noisy: &Noisy) -> Result<Filtered> {
        match self {
            Self::NonLocalMeans => Ok(own::filter(noisy)),
            #[cfg(feature = "oidn")]
            Self::OpenImageDenoise => trained::filter(noisy),
        }
    }
}

/// A filtered picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Filtered {
    /// The picture.
    pub image: Image,
    /// How far each pixel is likely to be from the truth, by its noise and by its bias: a mean over its neighbourhood.
    pub errors: Image,
    /// The estimated root of relMSE, bias included, with the filtered picture as the truth in its denominator; `None` for a
    /// black picture.
    pub error: Option<f64>,
}
