//! What is compared: a backend, built and asked in one of several ways.
//!
//! Measure: none.
//! Range: the backends of this build.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use etendue::internals::accel::batch::{PacketWidth, Packets};
use etendue::internals::accel::{AccelOptions, Backend, Precision, Quality};
use serde::{Serialize, Serializer};

/// A way of building a backend's structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct Target {
    /// The library.
    #[serde(serialize_with = "backend_name")]
    pub backend: Backend,
    /// How carefully it intersects.
    #[serde(serialize_with = "precision_name")]
    pub precision: Precision,
    /// How well it is built.
    #[serde(serialize_with = "quality_name")]
    pub quality: Quality,
}

impl Target {
    /// Every way of building each of these backends.
    pub fn all(backends: &[Backend]) -> Vec<Self> {
        let mut targets = vec![];
        for &backend in backends {
            for precision in [Precision::Robust, Precision::Fast] {
                for quality in [Quality::High, Quality::Medium] {
                    targets.push(Self {
                        backend,
                        precision,
                        quality,
                    });
                }
            }
        }
        targets
    }

    /// Every way of tracing rays through it: only Embree has packets, and of one ray all are alike.
    pub fn variants(self) -> Vec<Variant> {
        let packets = PacketWidth::ALL
            .iter()
            .flat_map(|&width| [false, true].map(|coherent| Packets { width, coherent }));
        let single = Packets::default();
        let packets = packets.filter(|packets| {
            *packets == single || self.is_embree() && packets.width != single.width
        });
        packets
            .map(|packets| Variant {
                target: self,
                packets,
            })
            .collect()
    }

    /// Whether the library is Embree.
    pub fn is_embree(self) -> bool {
        self.backend.is_embree()
    }

    /// The options that build it.
    pub fn options(self, threads: usize) -> AccelOptions {
        AccelOptions {
            backend: self.backend,
            precision: self.precision,
            quality: Some(self.quality),
            threads,
        }
    }

    /// Whether the same structure is built for both: obvhs heeds precision only when it traces.
    pub fn builds_like(self, other: Self) -> bool {
        let precision_matters = self.is_embree();
        (self.backend, self.quality) == (other.backend, other.quality)
            && (self.precision == other.precision || !precision_matters)
    }

    /// Its name in tables, such as `embree fast high`.
    pub fn name(self) -> String {
        [
            self.backend.name(),
            self.precision.name(),
            self.quality.name(),
        ]
        .join(" ")
    }
}

/// A way of tracing rays through a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct Variant {
    /// What is asked.
    #[serde(flatten)]
    pub target: Target,
    /// In packets of which width, coherent or not.
    #[serde(flatten, serialize_with = "packets")]
    pub packets: Packets,
}

fn backend_name<S: Serializer>(backend: &Backend, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(backend.name())
}

fn precision_name<S: Serializer>(precision: &Precision, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(precision.name())
}

fn quality_name<S: Serializer>(quality: &Quality, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(quality.name())
}

fn packets<S: Serializer>(packets: &Packets, serializer: S) -> Result<S::Ok, S::Error> {
    use serde::ser::SerializeMap;
    let mut map = serializer.serialize_map(Some(2))?;
    map.serialize_entry("width", &packets.width.lanes())?;
    map.serialize_entry("coherent", &packets.coherent)?;
    map.end()
}
