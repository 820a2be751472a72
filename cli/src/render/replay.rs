//! `etendue render --pixel x,y --sample n`: a single path, vertex by vertex.
//!
//! Measure: world units; radiance.
//! Range: pixels of the image.
//! Source: none needed. Tested in `cli/tests/command/render.rs`.

use super::job::RenderJob;
use crate::{Outcome, print};
use etendue::internals::film::filter::Filter;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::render::replay::{PathEvent, replay};
use etendue::{Error, Result};
use std::fmt::Write;

pub fn run(job: &RenderJob<'_>, filter: &Filter, pixel: [u32; 2], sample: u64) -> Result<Outcome> {
    let (width, height) = job.description.film.size;
    if pixel[0] >= width || pixel[1] >= height {
        return Err(Error::usage(format!(
            "--pixel {},{} is outside the image of {width}x{height} pixels",
            pixel[0], pixel[1]
        )));
    }
    let path = replay(job.scene, filter, job.settings, pixel, sample)?;
    let mut text = format!("pixel {},{} sample {sample}\n", pixel[0], pixel[1]);
    let mut vertex = 0;
    for event in &path.events {
        let line = describe(job, event, &mut vertex);
        writeln!(text, "{line}").expect("writing to a string cannot fail");
    }
    if let Some(alone) = path.alone {
        writeln!(text, "radiance of this path alone {}", rgb(alone))
            .expect("writing to a string cannot fail");
        writeln!(
            text,
            "with the paths of {} pixels:",
            job.settings.reuse().name()
        )
        .expect("writing to a string cannot fail");
    }
    writeln!(text, "radiance {}", rgb(path.radiance)).expect("writing to a string cannot fail");
    print(text.as_bytes())
}

fn describe(job: &RenderJob<'_>, event: &PathEvent, vertex: &mut u32) -> String {
    match event {
        PathEvent::Arrived {
            position,
            shape,
            primitive,
            normal,
            beta,
        } => {
            let index = *vertex;
            *vertex += 1;
            let name = &job.description.shapes[job.scene.described(*shape)].name;
            format!(
                "vertex {index}: {name} primitive {primitive} at {position:.6}, normal {normal:.4}, throughput {}",
                rgb(*beta)
            )
        }
        PathEvent::Escaped { direction } => format!("  left the scene along {direction:.4}"),
        PathEvent::Emission {
            contribution,
            weight,
        } => {
            format!("  emission {} (weight {weight:.4})", rgb(*contribution))
        }
        PathEvent::Light {
            contribution,
            weight,
            visible,
        } => {
            let seen = match *visible {
                0.0 => "hidden".to_owned(),
                1.0 => "visible".to_owned(),
                share => format!("{:.1} % visible", 100.0 * share),
            };
            format!(
                "  light sample {}, {seen} (weight {weight:.4})",
                rgb(*contribution)
            )
        }
        PathEvent::CachedIndirect { contribution } => {
            format!("  indirect light {} by the cache", rgb(*contribution))
        }
        PathEvent::Scattered {
            direction,
            lobe,
            beta,
        } => {
            format!(
                "  scattered along {direction:.4} ({lobe:?}), throughput {}",
                rgb(*beta)
            )
        }
        PathEvent::Terminated { survival } => {
            format!("  ended by roulette (survival {survival:.4})")
        }
    }
}

fn rgb(colour: Rgb) -> String {
    let [r, g, b] = colour.to_array();
    format!("({r:.6}, {g:.6}, {b:.6})")
}
