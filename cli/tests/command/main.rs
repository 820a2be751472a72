//! Tests of the command line program.

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "../support/command.rs"]
mod support;

mod adaptive;
mod auto;
mod bad_flags;
mod bad_input;
mod bad_motion;
mod battery;
mod bench;
#[cfg(feature = "embree")]
mod c_library;
mod checkpoints;
mod choices;
mod compare;
mod convert;
mod denoise;
mod denoise_oidn;
#[cfg(all(feature = "embree", target_arch = "x86_64"))]
mod instruction_sets;
mod layers;
mod lesson;
mod non_finite;
mod plan;
mod price;
mod render;
mod scene_formats;
mod shards;
mod shared_cache;
#[cfg(unix)]
mod slurm_scripts;
mod state_identity;
mod study;
mod study_shards;
