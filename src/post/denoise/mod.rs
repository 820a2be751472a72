//! Denoisers: the image with its noise filtered, and an estimate of its remaining error.
//!
//! Measure: linear radiance; errors as roots of relMSE.
//! Range: an image with its first half, standard errors and first hits. Filtered images are biased; the bias of the
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

pub use noisy::NoisyImage;

use crate::error::Result;
use crate::image::Image;

/// The denoisers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Denoiser {
    /// Non-local means over the halves of the image, guided by first hits.
    NonLocalMeans,
    /// Intel's Open Image Denoise, where it is found.
    #[cfg(feature = "oidn")]
    OpenImageDenoise,
}

impl Denoiser {
    /// All denoisers of this build.
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

    /// The bias of the denoiser, in words.
    pub fn bias(self) -> &'static str {
        match self {
            Self::NonLocalMeans => {
                "denoise nlm: neighbouring pixels are mixed, less so the less noise there is"
            }
            #[cfg(feature = "oidn")]
            Self::OpenImageDenoise => "denoise oidn: a trained network made this image",
        }
    }

    /// Checks that the denoiser is available, to fail before a long render.
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

    /// Filters an image. The result has the same bits for any number of threads.
    ///
    /// # Errors
    /// If a library is not found, or fails.
    pub fn filter(self, noisy: &NoisyImage) -> Result<Filtered> {
        match self {
            Self::NonLocalMeans => Ok(own::filter(noisy)),
            #[cfg(feature = "oidn")]
            Self::OpenImageDenoise => trained::filter(noisy),
        }
    }
}

/// A filtered image.
#[derive(Debug, Clone, PartialEq)]
pub struct Filtered {
    /// The image.
    pub image: Image,
    /// The estimated error of each pixel by its noise and by its bias: a mean over its neighbourhood.
    pub errors: Image,
    /// The estimated root of relMSE, bias included, with the filtered image as the truth in its denominator; `None`
    /// for a black image.
    pub error: Option<f64>,
}
