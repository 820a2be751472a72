//! Loads a scene, renders it to an error, and writes the image with its layers.
//!
//! `cargo run --release --example load_and_render -- scenes/cornell-box/cornell-box.toml box.exr 5`

use etendue::{
    Error, Progress, RenderObserver, RenderOptions, Result, Session, WriteOptions, tracing, write,
};
use std::path::Path;

/// Prints how far the render has come.
struct Printer;

impl RenderObserver for Printer {
    fn progress(&self, progress: &Progress) {
        eprint!("\r{:3.0} %", 100.0 * progress.fraction);
    }
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, out, percent] = arguments.as_slice() else {
        return Err(Error::usage("usage: load_and_render SCENE OUT PERCENT"));
    };
    let percent: f64 = percent
        .parse()
        .map_err(|error| Error::usage("expected a number of percent").because(error))?;

    let session = Session::load(Path::new(scene), tracing())?;
    for note in session.notes() {
        eprintln!("note: {note}");
    }
    let mut options = RenderOptions::default();
    options.error = Some(percent / 100.0);
    options.layers = true;
    let rendering = session.render(&options, &Printer)?;

    let picture = rendering.layered(&session)?;
    let options = WriteOptions {
        layers: picture.layers,
        ..WriteOptions::default()
    };
    write(Path::new(out), &picture.image, &options)?;
    if let Some(error) = rendering.error(0.95) {
        let [error, bound] = [error.rel_rmse, error.upper_bound].map(|error| 100.0 * error);
        let spp = rendering.spp();
        println!("\r{out}: {spp} spp, error {error:.2} % (below {bound:.2} % at 95 % confidence)");
    }
    Ok(())
}
