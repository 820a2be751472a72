//! The fuzz targets: the use of the bytes of each, and the properties that have to hold.
//!
//! Measure: bytes.
//! Range: any bytes. A scene or model that is not valid has to end in an error that names the file, kept short; one that
//! is valid is made ready and sampled a little. Memory is bounded by the input's size, see [`Target::feed`].
//! Source: cargo-fuzz runs the targets (`make fuzz`); `tests/fuzz_corpus.rs` includes this file to replay the corpus.

use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::film::filter::Filter;
use etendue::internals::image::{ColourSpace, Image, LayeredImage};
use etendue::internals::render::replay::replay;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::description::{
    GeometryDescription, SceneDescription, ShapeDescription,
};
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
use etendue::internals::state::{State, with_checksum};
use etendue::{Error, ErrorKind};
use peak_alloc::PeakAlloc;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::path::Path;
use std::sync::LazyLock;
use tempfile::TempDir;

/// A target: the code that an input is given to.
pub struct Target {
    /// Also the name of its folder in the corpus.
    pub name: &'static str,
    run: fn(&[u8]),
    /// Bytes of memory for each byte of the input, at most.
    per_byte: usize,
}

/// A scene file. It may name `m.obj`, `t.pfm` and `broken.png`.
pub const SCENE_TOML: Target = Target {
    name: "scene_toml",
    run: |bytes| load_bytes("fuzzed.toml", bytes, "fuzzed.toml"),
    per_byte: FOR_TEXT,
};

/// A bare model. It may name the library `m.mtl`.
pub const OBJ: Target = Target {
    name: "obj",
    run: |bytes| load_bytes("fuzzed.obj", bytes, "fuzzed.obj"),
    per_byte: FOR_MODELS,
};

/// The library of a model.
pub const MTL: Target = Target {
    name: "mtl",
    run: |bytes| load_bytes("fuzzed.mtl", bytes, "library.obj"),
    per_byte: FOR_TEXT,
};

/// A bare model in PLY.
pub const PLY: Target = Target {
    name: "ply",
    run: |bytes| load_bytes("fuzzed.ply", bytes, "fuzzed.ply"),
    per_byte: FOR_MODELS,
};

/// A scene of Mitsuba. It may name `m.obj` and `broken.png`, and include itself.
pub const MITSUBA_XML: Target = Target {
    name: "mitsuba_xml",
    run: |bytes| load_bytes("fuzzed.xml", bytes, "fuzzed.xml"),
    per_byte: FOR_XML,
};

/// A glTF file, of either container. It may name `b.bin` and `t.pfm`.
pub const GLTF: Target = Target {
    name: "gltf",
    run: |bytes| load_bytes("fuzzed.gltf", bytes, "fuzzed.gltf"),
    per_byte: FOR_COMPRESSED,
};

/// A picture of any format that is read; the first bytes tell which.
pub const IMAGE: Target = Target {
    name: "image",
    run: image,
    per_byte: FOR_COMPRESSED,
};

/// A scene of pbrt. It may name `m.ply`, `t.pfm`, `part.pbrt` and `broken.png`.
pub const PBRT: Target = Target {
    name: "pbrt",
    run: |bytes| load_bytes("fuzzed.pbrt", bytes, "fuzzed.pbrt"),
    per_byte: FOR_TEXT,
};

/// A state file without its checksum, which is added: no fuzzer would guess it.
pub const STATE: Target = Target {
    name: "state",
    run: state,
    per_byte: FOR_SUMS,
};

/// All of them.
pub const TARGETS: [Target; 9] = [
    SCENE_TOML,
    OBJ,
    MTL,
    PLY,
    MITSUBA_XML,
    PBRT,
    GLTF,
    IMAGE,
    STATE,
];

/// Text: the acceptance rule of the project's catalogue of hard cases.
const FOR_TEXT: usize = 64;
/// A corner of a polygon takes a byte or two, and colours give its triangle texels and vertices of its own.
const FOR_MODELS: usize = 512;
/// An element takes eight bytes; it becomes a node, and a property with its place.
const FOR_XML: usize = 256;
/// Pictures: deflate makes 1032 bytes of eight pixels out of one, and each takes twelve bytes and what decoders need.
const FOR_COMPRESSED: usize = 8 * 1032 * 32;
/// Sums: a black pixel takes four bytes of a file and two hundred of memory, with counts or without; and tiles of one pixel
/// take more.
const FOR_SUMS: usize = 128;
/// Bytes of memory for anything: tables, the trees of a few shapes, the folder's own files.
const FOR_ANYTHING: usize = 8 << 20;
/// Primitives of a scene that is traced, too: obvhs builds a tree of coincident ones in a time that grows with the square of
/// their number.
const MAX_TRACED: usize = 4096;
/// Bytes of a message: it repeats little of the file.
const MAX_MESSAGE: usize = 8 << 10;

/// Files that what is fuzzed may name.
const NAMED: [(&str, &[u8]); 8] = [
    (
        "m.obj",
        b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n",
    ),
    ("m.mtl", b"newmtl a\nKd 1 0 0\nKe 1 1 1\nnewmtl b\nPr 0.5\n"),
    ("t.pfm", b"Pf\n2 1\n-1\n\0\0\0\x3f\0\0\x80\x3f"),
    (
        "b.bin",
        b"\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\0\x01\x02\0",
    ),
    ("library.obj", MODEL),
    ("broken.png", b"\x89PNG\r\n\x1a\n"),
    ("part.pbrt", b"Translate 1 0 0\nShape \"disk\"\n"),
    (
        "m.ply",
        b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
          element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    ),
];

/// A model whose library is fuzzed; its faces have both of its materials.
const MODEL: &[u8] =
    b"mtllib fuzzed.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n\
                     usemtl b\nf 3/1 2/1 1/1\n";

/// Each process has a folder of its own.
static FOLDER: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, content) in NAMED {
        std::fs::write(folder.path().join(name), content).expect("the folder is writable");
    }
    folder
});

/// The backends build on these threads, in place of new ones for each input.
static THREAD: LazyLock<ThreadPool> = LazyLock::new(|| {
    let pool = ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("one thread can be started")
});

impl Target {
    /// Feeds it.
    ///
    /// # Panics
    /// If the program does, if it breaks its word, or if it takes more memory than it may at its peak. Other threads must
    /// not allocate meanwhile.
    pub fn feed(&self, bytes: &[u8], memory: &PeakAlloc) {
        LazyLock::force(&FOLDER);
        LazyLock::force(&THREAD);
        let before = memory.current_usage();
        memory.reset_peak_usage();
        (self.run)(bytes);
        let taken = memory.peak_usage().saturating_sub(before);
        let allowed = FOR_ANYTHING + self.per_byte * bytes.len();
        assert!(
            taken <= allowed,
            "{taken} bytes of memory for {} of input",
            bytes.len()
        );
    }
}

fn image(bytes: &[u8]) {
    for space in [ColourSpace::Srgb, ColourSpace::Linear] {
        match Image::decode(bytes, space) {
            Ok(image) => assert!(image.pixels().iter().all(|pixel| pixel.is_finite())),
            Err(error) => check_error(&error, &[ErrorKind::Scene]),
        }
    }
    layered(bytes);
}

/// With its layers, the picture is the same, and every layer has a sample for each of its pixels.
fn layered(bytes: &[u8]) {
    match LayeredImage::decode(bytes, ColourSpace::Linear) {
        Ok(read) => {
            let pixels = read.image.pixels().len();
            assert!(
                read.layers
                    .iter()
                    .all(|layer| layer.samples.len() == pixels)
            );
            let alone = Image::decode(bytes, ColourSpace::Linear);
            assert_eq!(read.image, alone.expect("it is valid with its layers"));
        }
        Err(error) => check_error(&error, &[ErrorKind::Scene]),
    }
}

/// Reads a state, and estimates its error.
fn state(bytes: &[u8]) {
    match State::decode(&with_checksum(bytes.to_vec())) {
        Ok(state) => {
            let pixels = state.header.window.pixel_count() as usize;
            assert_eq!(state.film.develop().pixels().len(), pixels);
            assert!(state.layers.iter().all(|it| it.samples.len() == pixels));
            state.needed_spp(0.01, 0.95);
        }
        Err(error) => check_error(&error, &[ErrorKind::Io]),
    }
}

/// Writes a file, loads a scene that consists of it or names it, and goes on with what is valid.
fn load_bytes(file: &str, bytes: &[u8], scene: &str) {
    let folder = FOLDER.path();
    std::fs::write(folder.join(file), bytes).expect("the folder is writable");
    let scene = folder.join(scene);
    match load(&scene) {
        Ok(description) => load_and_render(description),
        Err(error) => {
            check_error(&error, &[ErrorKind::Scene, ErrorKind::Io]);
            check_place(&error, &scene);
        }
    }
}

/// Makes a valid scene ready with every backend, and takes a few samples.
fn load_and_render(mut description: SceneDescription) {
    if primitives(&description) > MAX_TRACED {
        return;
    }
    let Ok(mut settings) = RenderSettings::of_scene(&description) else {
        return;
    };
    let size = (2, 2);
    description.film.size = size;
    // Between mirrors, paths are as long as chance has it.
    settings.max_bounces = Some(8);
    let filter = Filter::new(&description.film.filter);
    for &backend in Backend::ALL {
        let options = AccelOptions {
            backend,
            precision: Precision::Robust,
            quality: None,
            threads: 1,
        };
        let prepared = match THREAD.install(|| prepare(&description, options)) {
            Ok(prepared) => prepared,
            Err(error) => return check_error(&error, &[ErrorKind::Scene]),
        };
        for pixel in [[0, 0], [1, 1]] {
            if let Err(error) = replay(&prepared.scene, &filter, &settings, pixel, 0) {
                return check_error(&error, &[ErrorKind::Usage]);
            }
        }
    }
}

/// Triangles and round shapes of a scene.
fn primitives(description: &SceneDescription) -> usize {
    let count = |shape: &ShapeDescription| match &shape.geometry {
        GeometryDescription::Mesh(mesh) => mesh.indices.len(),
        _ => 1,
    };
    description.shapes.iter().map(count).sum()
}

/// An error is of one of these kinds, and short.
fn check_error(error: &Error, kinds: &[ErrorKind]) {
    let message = error.to_string();
    assert!(
        kinds.contains(&error.kind()),
        "{:?}: {message}",
        error.kind()
    );
    assert!(
        message.len() <= MAX_MESSAGE,
        "{} bytes of message",
        message.len()
    );
}

/// An error begins with the file that was asked for.
fn check_place(error: &Error, scene: &Path) {
    let message = error.to_string();
    assert!(message.starts_with(&*scene.to_string_lossy()), "{message}");
}
