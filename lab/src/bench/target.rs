//! The targets of a comparison: a backend, with its build options and its ways of tracing.
//!
//! Measure: none.
//! Range: the backends of this build.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use etendue::internals::accel::batch::{PacketWidth, Packets};
use etendue::internals::accel::{AccelOptions, Backend, Precision, Quality};
use serde::{Serialize, Serializer};

/// A backend with the options that build its structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct BenchTarget {
    /// The backend.
    #[serde(serialize_with = "backend_name")]
    pub backend: Backend,
    /// The precision of its intersections.
    #[serde(serialize_with = "precision_name")]
    pub precision: Precision,
    /// The quality of its structure.
    #[serde(serialize_with = "quality_name")]
    pub quality: Quality,
}

impl BenchTarget {
    /// All combinations of these backends with each precision and quality.
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

    /// All ways of tracing rays through the target: only Embree has packets, and coherence has no effect on single
    /// rays.
    pub fn variants(self) -> Vec<TracingMode> {
        let packets = PacketWidth::ALL
            .iter()
            .flat_map(|&width| [false, true].map(|coherent| Packets { width, coherent }));
        let single = Packets::default();
        let packets = packets.filter(|packets| {
            *packets == single || self.is_embree() && packets.width != single.width
        });
        packets
            .map(|packets| TracingMode {
                target: self,
                packets,
            })
            .collect()
    }

    /// Whether the library is Embree.
    pub fn is_embree(self) -> bool {
        self.backend.is_embree()
    }

    /// The options for building the target.
    pub fn options(self, threads: usize) -> AccelOptions {
        AccelOptions {
            backend: self.backend,
            precision: self.precision,
            quality: Some(self.quality),
            threads,
        }
    }

    /// Whether both targets build the same structure: obvhs uses the precision only in traversal.
    pub fn builds_like(self, other: Self) -> bool {
        let precision_matters = self.is_embree();
        (self.backend, self.quality) == (other.backend, other.quality)
            && (self.precision == other.precision || !precision_matters)
    }

    /// The target's name in tables, such as `embree fast high`.
    pub fn name(self) -> String {
        [
            self.backend.name(),
            self.precision.name(),
            self.quality.name(),
        ]
        .join(" ")
    }
}

/// A way of tracing rays: a target and the kind of packets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct TracingMode {
    /// The target.
    #[serde(flatten)]
    pub target: BenchTarget,
    /// Width and coherence of the packets.
    #[serde(flatten, serialize_with = "packets")]
    pub packets: Packets,
}

pub(super) fn backend_name<S: Serializer>(
    backend: &Backend,
    serializer: S,
) -> Result<S::Ok, S::Error> {
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
