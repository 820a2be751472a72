//! Tests of loading scenes from files, and of the error messages for invalid ones.

#[path = "../common/mod.rs"]
mod common;

mod built_scenes;
mod colours;
mod damaged_files;
mod generated_files;
mod gltf;
mod gltf_bad;
mod gltf_builder;
mod gltf_odd;
mod lights;
mod mitsuba;
mod mitsuba_files;
mod mitsuba_shapes;
mod mitsuba_spectra;
mod models;
mod notes;
mod obj_by_tobj;
mod odd_models;
mod own_scenes;
mod pbrt;
mod pictures;
mod ply;
mod ply_records;
mod saving;
mod scene_files;
mod shared_meshes;
