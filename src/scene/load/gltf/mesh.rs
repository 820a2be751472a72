//! Meshes of glTF: the triangles of a primitive, with the vertices that they use.
//!
//! Measure: the file's own units; texture coordinates with v up, where glTF's has it down.
//! Range: triangles, strips and fans, indexed or not; indices within the vertices. Every list of accessors is read once,
//! and all meshes together have at most [`EXPANSION`] times as many bytes as the file.
//! Source: glTF 2.0, chapter 3.7.2. Tested in `tests/loading/gltf.rs`.

use super::accessor::{Elements, is_finite};
use super::buffers::Asset;
use crate::error::{Error, Result};
use crate::geometry::mesh::MIN_PER_THREAD;
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec2, DVec3};
use crate::memory;
use crate::scene::description::MeshDescription;
use gltf::Semantic;
use gltf::mesh::{Mode, Primitive};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Bytes of meshes for each byte of the file, at most. Small integers become numbers of 8 bytes, and each index of a
/// strip a triangle of 12 bytes; what is more refers to its data again and again.
const EXPANSION: usize = 64;

/// The colours of a primitive's vertices.
#[derive(Debug, Clone)]
pub enum VertexColours {
    /// All of them, and their alpha.
    Same(Rgb, f32),
    /// Colours that vary, one per vertex, their mean, and the mean alpha.
    Varying(Arc<Vec<Rgb>>, Rgb, f32),
}

/// The triangles of a primitive.
#[derive(Debug, Clone)]
pub struct PrimitiveMesh {
    pub mesh: Arc<MeshDescription>,
    pub colours: VertexColours,
}

/// The accessors of a primitive: position, normal, texture coordinate, colour and indices; and its mode.
type MeshKey = ([Option<usize>; 5], u8);

/// Reads meshes, each list of accessors once.
#[derive(Debug)]
pub struct Meshes {
    known: HashMap<MeshKey, PrimitiveMesh>,
    /// The bytes that meshes may still take.
    left: usize,
}

/// The accessors of a primitive.
struct PrimitiveAccessors<'a> {
    positions: Elements<'a, 3>,
    normals: Option<Elements<'a, 3>>,
    uvs: Option<Elements<'a, 2>>,
}

impl Meshes {
    pub fn new(asset: &Asset<'_>) -> Self {
        Self {
            known: HashMap::new(),
            left: EXPANSION * asset.size(),
        }
    }

    /// Reads a primitive with texture coordinates `uv_set`; `None` if it has no triangles. `field` is its place in the
    /// JSON.
    ///
    /// # Errors
    /// If its accessors are not as the format requires.
    pub fn read(
        &mut self,
        asset: &Asset<'_>,
        primitive: &Primitive<'_>,
        uv_set: u32,
        field: &str,
    ) -> Result<Option<PrimitiveMesh>> {
        if !matches!(
            primitive.mode(),
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            return Ok(None);
        }
        let uvs = Semantic::TexCoords(uv_set);
        let attributes = [
            Semantic::Positions,
            Semantic::Normals,
            uvs,
            Semantic::Colors(0),
        ];
        let [positions, normals, uvs, colours] =
            attributes.map(|semantic| primitive.get(&semantic));
        let indices = primitive.indices();
        let ids = [&positions, &normals, &uvs, &colours, &indices]
            .map(|accessor| accessor.as_ref().map(|accessor| accessor.index()));
        let key = (ids, primitive.mode() as u8);
        if let Some(known) = self.known.get(&key) {
            return Ok(Some(known.clone()));
        }
        let Some(positions) = positions else {
            return Err(asset.error(field, "expected an attribute POSITION"));
        };
        let source = PrimitiveAccessors {
            positions: Elements::new(asset, &positions)?,
            normals: normals.map(|it| Elements::new(asset, &it)).transpose()?,
            uvs: uvs.map(|it| Elements::new(asset, &it)).transpose()?,
        };
        let count = source.positions.count();
        if u32::try_from(count).is_err() {
            return Err(asset.error(field, "expected fewer than 2^32 vertices"));
        }
        let others = [
            source.normals.as_ref().map(Elements::count),
            source.uvs.as_ref().map(Elements::count),
            colours.as_ref().map(|it| it.count()),
        ];
        if let Some(other) = others.into_iter().flatten().find(|&other| other != count) {
            return Err(asset.error(
                field,
                format!("expected as many of each attribute as there are positions, {count}, found {other}"),
            ));
        }
        let triangles = match &indices {
            Some(indices) => self.indexed(asset, indices, primitive.mode(), count)?,
            None => {
                self.take(asset, field, 4 * count)?;
                triangles(primitive.mode(), count, |i| i as u32)
            }
        };
        let (used, triangles) = compact(triangles, count);
        self.take(asset, field, used.len() * 8 * (3 + 3 + 2))?;
        let of_colours = colours.as_ref().map(|it| colours_of(asset, it, &used));
        let mesh = PrimitiveMesh {
            mesh: Arc::new(source.mesh(asset, &used, triangles, field)?),
            colours: of_colours
                .transpose()?
                .unwrap_or(VertexColours::Same(Rgb::WHITE, 1.0)),
        };
        self.known.insert(key, mesh.clone());
        Ok(Some(mesh))
    }

    /// Reads the triangles of an indexed primitive with `count` vertices.
    fn indexed(
        &mut self,
        asset: &Asset<'_>,
        accessor: &gltf::Accessor<'_>,
        mode: Mode,
        count: usize,
    ) -> Result<Vec<[u32; 3]>> {
        let field = format!("accessors[{}]", accessor.index());
        let indices = Elements::<1>::new(asset, accessor)?;
        if !indices.is_unsigned() {
            return Err(asset.error(field, "expected unsigned integers as indices"));
        }
        self.take(asset, &field, 12 * indices.count())?;
        let found = triangles(mode, indices.count(), |i| indices.index(i));
        let corners = found.as_flattened().par_iter();
        let most = corners.with_min_len(MIN_PER_THREAD).copied().max();
        if let Some(most) = most.filter(|&most| most as usize >= count) {
            let message = format!("expected indices of {count} vertices, found {most}");
            return Err(asset.error(field, message));
        }
        Ok(found)
    }

    /// Takes bytes from those that are left.
    pub fn take(&mut self, asset: &Asset<'_>, field: &str, bytes: usize) -> Result<()> {
        memory::check(bytes as u64, || "a mesh".to_owned())?;
        self.left = self.left.checked_sub(bytes).ok_or_else(|| {
            let message = format!(
                "expected at most {EXPANSION} times the bytes of all buffers in all meshes: they refer to the same data too often"
            );
            asset.error(field, message)
        })?;
        Ok(())
    }
}

impl PrimitiveAccessors<'_> {
    fn mesh(
        &self,
        asset: &Asset<'_>,
        used: &Used,
        indices: Vec<[u32; 3]>,
        field: &str,
    ) -> Result<MeshDescription> {
        let wrong = |what: &'static str| {
            move |message: String| asset.error(field, format!("{what}: {message}"))
        };
        let vectors = |elements: &Elements<'_, 3>, what: &'static str| {
            let vectors = used.map(|i| elements.get(i), wrong(what))?;
            Ok(vectors.into_iter().map(DVec3::from_array).collect())
        };
        let uvs = |elements: &Elements<'_, 2>| {
            let uvs = used.map(|i| elements.get(i), wrong("TEXCOORD"))?;
            Ok(uvs
                .into_iter()
                .map(|[u, v]| DVec2::new(u, 1.0 - v))
                .collect())
        };
        let normals = self.normals.as_ref().map(|it| vectors(it, "NORMAL"));
        Ok(MeshDescription {
            positions: vectors(&self.positions, "POSITION")?,
            normals: normals.transpose()?.unwrap_or_default(),
            uvs: self.uvs.as_ref().map(uvs).transpose()?.unwrap_or_default(),
            indices,
        })
    }
}

/// The triangles of `count` vertices, given by their order in the file.
fn triangles(mode: Mode, count: usize, vertex: impl Fn(usize) -> u32 + Sync) -> Vec<[u32; 3]> {
    let corners = |[a, b, c]: [usize; 3]| [vertex(a), vertex(b), vertex(c)];
    let has_area = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    match mode {
        Mode::TriangleStrip => (2..count)
            .map(|i| corners([i - 2, i - 1 + i % 2, i - i % 2]))
            .filter(has_area)
            .collect(),
        Mode::TriangleFan => (2..count)
            .map(|i| corners([i - 1, i, 0]))
            .filter(has_area)
            .collect(),
        _ => (0..count / 3)
            .into_par_iter()
            .with_min_len(MIN_PER_THREAD)
            .map(|i| corners([3 * i, 3 * i + 1, 3 * i + 2]))
            .collect(),
    }
}

/// The vertices that triangles use, in the order of the file.
enum Used {
    /// The first ones.
    All(usize),
    Some(Vec<u32>),
}

impl Used {
    fn len(&self) -> usize {
        match self {
            Self::All(count) => *count,
            Self::Some(vertices) => vertices.len(),
        }
    }

    /// Returns the numbers of each vertex, which have to be finite in single precision.
    ///
    /// # Errors
    /// That of `wrong` for the first vertex whose numbers are not.
    fn map<const N: usize>(
        &self,
        numbers: impl Fn(usize) -> [f64; N] + Sync,
        wrong: impl Fn(String) -> Error,
    ) -> Result<Vec<[f64; N]>> {
        let vertex = |place: usize| match self {
            Self::All(_) => place,
            Self::Some(vertices) => vertices[place] as usize,
        };
        let places = (0..self.len()).into_par_iter().with_min_len(MIN_PER_THREAD);
        let all: Vec<[f64; N]> = places.map(|place| numbers(vertex(place))).collect();
        let values = all.par_iter().with_min_len(MIN_PER_THREAD);
        match values.position_first(|numbers| !is_finite(numbers)) {
            None => Ok(all),
            Some(place) => Err(wrong(format!(
                "expected finite numbers, found {:?} at element {}",
                all[place],
                vertex(place)
            ))),
        }
    }
}

/// Finds the vertices that are used, of `count`, and numbers them anew.
fn compact(mut triangles: Vec<[u32; 3]>, count: usize) -> (Used, Vec<[u32; 3]>) {
    let corners = triangles.as_flattened();
    // Parts of a large mesh may share its vertices: their time should not depend on the number of these.
    let mut used: Vec<u32> = if corners.len() < count / 4 {
        let mut sorted = corners.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        sorted
    } else {
        let mut is_used = Vec::with_capacity(count);
        is_used.resize_with(count, AtomicBool::default);
        let corners = corners.par_iter().with_min_len(MIN_PER_THREAD);
        corners.for_each(|corner| is_used[*corner as usize].store(true, Ordering::Relaxed));
        let all = is_used.par_iter().with_min_len(MIN_PER_THREAD);
        if all.all(|is_used| is_used.load(Ordering::Relaxed)) {
            return (Used::All(count), triangles);
        }
        let vertices = (0..count as u32).zip(is_used);
        let used = vertices.filter(|(_, is_used)| is_used.load(Ordering::Relaxed));
        used.map(|(vertex, _)| vertex).collect()
    };
    used.shrink_to_fit();
    if used.len() * 4 < count {
        for corner in triangles.as_flattened_mut() {
            // Every corner is among them.
            *corner = used.partition_point(|vertex| vertex < corner) as u32;
        }
    } else {
        let mut places = vec![0; count];
        for (place, &vertex) in used.iter().enumerate() {
            places[vertex as usize] = place as u32;
        }
        for corner in triangles.as_flattened_mut() {
            *corner = places[*corner as usize];
        }
    }
    (Used::Some(used), triangles)
}

/// Reads the colours of the used vertices.
fn colours_of(
    asset: &Asset<'_>,
    accessor: &gltf::Accessor<'_>,
    used: &Used,
) -> Result<VertexColours> {
    let wrong = |message: String| -> Error {
        asset.error(format!("accessors[{}]", accessor.index()), message)
    };
    let colours = if accessor.dimensions().multiplicity() == 3 {
        let elements = Elements::<3>::new(asset, accessor)?;
        let opaque = |i| {
            let [r, g, b] = elements.get(i);
            [r, g, b, 1.0]
        };
        used.map(opaque, wrong)?
    } else {
        let elements = Elements::<4>::new(asset, accessor)?;
        used.map(|i| elements.get(i), wrong)?
    };
    let colours = colours.into_iter();
    let colours: Vec<[f32; 4]> = colours
        .map(|colour| colour.map(|x| x.clamp(0.0, 1.0) as f32))
        .collect();
    let Some((&first, others)) = colours.split_first() else {
        return Ok(VertexColours::Same(Rgb::WHITE, 1.0));
    };
    let rgb = |[r, g, b, _]: [f32; 4]| Rgb::new(r, g, b);
    if others.iter().all(|colour| *colour == first) {
        return Ok(VertexColours::Same(rgb(first), first[3]));
    }
    let mut sums = [0.0; 4];
    for colour in &colours {
        for (sum, channel) in sums.iter_mut().zip(colour) {
            *sum += f64::from(*channel);
        }
    }
    let mean = sums.map(|sum| ((sum / colours.len() as f64) as f32).clamp(0.0, 1.0));
    let varying = colours.into_iter().map(rgb).collect();
    Ok(VertexColours::Varying(
        Arc::new(varying),
        rgb(mean),
        mean[3],
    ))
}
