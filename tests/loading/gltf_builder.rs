//! Small glTF files, made in code.
//!
//! Measure: none.
//! Range: any JSON; nothing is checked here.
//! Source: glTF 2.0.

use crate::common::scene_folder::SceneFolder;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use etendue::internals::scene::description::{
    GeometryDescription, MeshDescription, SceneDescription,
};
use etendue::internals::scene::load::load;

/// Component types.
pub const U8: u32 = 5121;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A file in progress: its buffer, and the lists of views and accessors.
#[derive(Debug, Default, Clone)]
pub struct Builder {
    pub bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

pub fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

impl Builder {
    /// Adds a view of these bytes, with further keys, and returns its index.
    pub fn view(&mut self, bytes: &[u8], more: &str) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.bytes.extend(bytes);
        self.views.push(format!(
            "{{\"buffer\":0,\"byteOffset\":{offset},\"byteLength\":{length}{more}}}"
        ));
        self.views.len() - 1
    }

    /// Adds an accessor, with further keys, and returns its index.
    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, more: &str) -> usize {
        self.accessors.push(format!(
            "{{\"type\":\"{kind}\",\"componentType\":{component},\"count\":{count}{more}}}"
        ));
        self.accessors.len() - 1
    }

    /// Adds a view with an accessor of all of it.
    pub fn add(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes, "");
        self.accessor(kind, component, count, &format!(",\"bufferView\":{view}"))
    }

    /// The JSON with these further keys, and a buffer with this key, such as `"uri":"a.bin",`.
    fn json(&self, more: &str, uri: &str) -> String {
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\n\"buffers\":[{{{uri}\"byteLength\":{}}}],\n\
             \"bufferViews\":[{}],\n\"accessors\":[{}],\n{more}}}",
            self.bytes.len(),
            self.views.join(","),
            self.accessors.join(",")
        )
    }

    /// A `.gltf` file with its buffer in a `data:` URI.
    pub fn gltf(&self, more: &str) -> String {
        let data = STANDARD.encode(&self.bytes);
        let uri = format!("\"uri\":\"data:application/octet-stream;base64,{data}\",");
        self.json(more, &uri)
    }

    /// A `.gltf` file whose buffer is another file.
    pub fn gltf_beside(&self, more: &str, file: &str) -> String {
        self.json(more, &format!("\"uri\":\"{file}\","))
    }

    /// A `.glb` file.
    pub fn glb(&self, more: &str) -> Vec<u8> {
        let mut json = self.json(more, "").into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bytes.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend(((28 + json.len() + bin.len()) as u32).to_le_bytes());
        for (kind, content) in [(b"JSON", &json), (b"BIN\0", &bin)] {
            bytes.extend((content.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(content);
        }
        bytes
    }

    /// Loads the file of these further keys.
    pub fn load(&self, more: &str) -> SceneDescription {
        loaded(&self.gltf(more))
    }
}

/// Loads a `.gltf` file, which is valid.
pub fn loaded(text: &str) -> SceneDescription {
    SceneFolder::new([("a.gltf", text)]).load("a.gltf")
}

/// The message of the error of a `.gltf` file, without its folder.
pub fn refused(text: &str) -> String {
    let folder = SceneFolder::new([("a.gltf", text)]);
    let error = load(&folder.path("a.gltf")).expect_err("not valid");
    let message = error.to_string();
    message.replace(&format!("{}/", folder.root().display()), "")
}

/// A square of two triangles in the plane z = 0, with texture coordinates, and the indices of its accessors: positions,
/// texture coordinates, indices.
pub fn square() -> (Builder, [usize; 3]) {
    let mut builder = Builder::default();
    let positions = floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    let positions = builder.add("VEC3", F32, 4, &positions);
    let uvs = builder.add("VEC2", F32, 4, &floats(&[0., 1., 1., 1., 1., 0., 0., 0.]));
    let indices = builder.add("SCALAR", U8, 6, &[0, 1, 2, 0, 2, 3]);
    (builder, [positions, uvs, indices])
}

/// One node with one mesh of one primitive, which has these keys.
pub fn one_mesh(primitive: &str) -> String {
    format!("\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{{{primitive}}}]}}]")
}

/// The square with a material, and further keys of the file.
pub fn with_material(material: &str, more: &str) -> SceneDescription {
    let (builder, [positions, uvs, indices]) = square();
    let mesh = one_mesh(&format!(
        "\"attributes\":{{\"POSITION\":{positions},\"TEXCOORD_0\":{uvs}}},\"indices\":{indices},\"material\":0"
    ));
    builder.load(&format!("{mesh},\"materials\":[{{{material}}}]{more}"))
}

/// The mesh of a shape.
pub fn mesh(scene: &SceneDescription, shape: usize) -> &MeshDescription {
    let GeometryDescription::Mesh(mesh) = &scene.shapes[shape].geometry else {
        panic!("a mesh");
    };
    mesh
}

/// A PNG of two texels, red of alpha 0.4 and green of alpha 1, as a `data:` URI.
pub fn picture() -> String {
    let mut bytes = vec![];
    let samples = [255, 0, 0, 102, 0, 255, 0, 255];
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    image::ImageEncoder::write_image(encoder, &samples, 2, 1, image::ExtendedColorType::Rgba8)
        .expect("encoded");
    format!("data:image/png;base64,{}", STANDARD.encode(bytes))
}
