//! `etendue info`: the version and features of the program, and the capabilities of the machine.
//!
//! Measure: none.
//! Range: any machine; an unavailable fact is reported as unknown.
//! Source: none needed. Tested in `cli/tests/command/render.rs`.

use super::args::InfoArguments;
use super::{Outcome, print};
use etendue::Result;
use etendue::internals::accel::Backend;
use etendue::internals::accel::embree_info;
use etendue::internals::render::settings::available_threads;
use serde::Serialize;

/// The facts that `info` prints.
#[derive(Debug, Serialize)]
struct Info {
    version: &'static str,
    features: Vec<&'static str>,
    backends: Vec<&'static str>,
    instruction_set: Vec<&'static str>,
    threads: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    embree: Option<Embree>,
}

/// The linked Embree.
#[derive(Debug, Serialize)]
struct Embree {
    library_version: String,
    header_version: String,
    fits: bool,
    library: Option<String>,
    native_packet_widths: Vec<usize>,
}

pub fn run(arguments: &InfoArguments) -> Result<Outcome> {
    let info = Info {
        version: env!("CARGO_PKG_VERSION"),
        features: features(),
        backends: Backend::ALL.iter().map(|backend| backend.name()).collect(),
        instruction_set: instruction_set(),
        threads: available_threads(),
        embree: embree()?,
    };
    let text = if arguments.json {
        let json = serde_json::to_string_pretty(&info).expect("plain data always serialises");
        json + "\n"
    } else {
        table(&info)
    };
    print(text.as_bytes())
}

fn table(info: &Info) -> String {
    let mut rows = vec![
        ("etendue", info.version.to_owned()),
        ("features", info.features.join(", ")),
        ("backends", info.backends.join(", ")),
    ];
    match &info.embree {
        Some(embree) => {
            let widths: Vec<String> = embree
                .native_packet_widths
                .iter()
                .map(usize::to_string)
                .collect();
            let fits = if embree.fits {
                "compatible"
            } else {
                "NOT compatible: rebuild"
            };
            rows.push((
                "embree",
                format!(
                    "library {}, headers {}: {fits}",
                    embree.library_version, embree.header_version
                ),
            ));
            rows.push((
                "loaded from",
                embree.library.clone().unwrap_or("unknown".to_owned()),
            ));
            rows.push(("packet widths", widths.join(", ")));
        }
        None => rows.push(("embree", "not in this build".to_owned())),
    }
    rows.push(("instruction set", info.instruction_set.join(", ")));
    rows.push(("threads", info.threads.to_string()));
    rows.iter()
        .map(|(name, value)| format!("{name:<16} {value}\n"))
        .collect()
}

fn features() -> Vec<&'static str> {
    let all = [
        ("embree", cfg!(feature = "embree")),
        ("flip", cfg!(feature = "flip")),
        ("oidn", cfg!(feature = "oidn")),
    ];
    all.into_iter()
        .filter(|&(_, on)| on)
        .map(|(name, _)| name)
        .collect()
}

/// Returns the instruction set extensions of this processor that Embree and Etendue can use.
fn instruction_set() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    {
        let all = [
            ("sse4.2", is_x86_feature_detected!("sse4.2")),
            ("avx", is_x86_feature_detected!("avx")),
            ("avx2", is_x86_feature_detected!("avx2")),
            ("fma", is_x86_feature_detected!("fma")),
            ("avx512f", is_x86_feature_detected!("avx512f")),
        ];
        all.into_iter()
            .filter(|&(_, on)| on)
            .map(|(name, _)| name)
            .collect()
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        vec![std::env::consts::ARCH]
    }
}

fn embree() -> Result<Option<Embree>> {
    let info = embree_info()?;
    Ok(info.map(|info| Embree {
        fits: info.fits(),
        library_version: info.library_version,
        header_version: info.header_version,
        library: info.library.map(|path| path.display().to_string()),
        native_packet_widths: info.native_widths,
    }))
}
