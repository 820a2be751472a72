//! Holds an image of somebody else's against the truth: renders the scene until the error is small beside the difference, and
//! tells how far the image is off, and where it is by more than chance.
//!
//! `cargo run --release --example ground_truth -- scene.toml picture.exr`

use etendue::{
    ColourSpace, Error, Image, NullRenderObserver, RenderOptions, Result, Session, rel_mse, tracing,
};
use std::path::Path;

/// Samples per pixel that are added at a time.
const STEP: u64 = 64;

/// Samples per pixel at most.
const MAX_SPP: u64 = 4096;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, picture] = arguments.as_slice() else {
        return Err(Error::usage("usage: ground_truth SCENE PICTURE"));
    };
    let picture = Image::read(Path::new(picture), ColourSpace::Srgb)?;
    let session = Session::load(Path::new(scene), tracing())?;
    let options = RenderOptions::samples(STEP);
    let mut truth = session.render(&options, &NullRenderObserver)?;
    loop {
        let reference = truth.image();
        let size = |image: &Image| (image.width(), image.height());
        if size(&reference) != size(&picture) {
            return Err(Error::usage("the picture and the scene differ in size"));
        }
        // The difference has both errors, the image's and the reference's.
        let off = rel_mse(&picture, &reference)?.sqrt();
        let error = truth.error(0.95).map_or(1.0, |error| error.upper_bound);
        println!(
            "{} spp: off by {:.2} %, of which the reference {:.2} %",
            truth.spp(),
            100.0 * off,
            100.0 * error
        );
        if error < 0.2 * off || truth.spp() >= MAX_SPP {
            break;
        }
        truth.add_samples(&session, truth.spp(), &NullRenderObserver)?;
    }
    let reference = truth.image();
    let bars = truth.error_bars();
    let errors = bars.expect("there are many samples").standard_errors;
    let pixels = picture.pixels().iter().zip(reference.pixels());
    let outside = pixels.zip(errors.pixels()).filter(|((a, b), error)| {
        let apart = (a.luminance() - b.luminance()).abs();
        apart > 4.0 * error.luminance()
    });
    println!(
        "{} of {} pixels are more than 4 standard errors of the reference off",
        outside.count(),
        picture.pixels().len()
    );
    Ok(())
}
