//! A checked OBJ file, and the texts in which the parser reads it safely.
//!
//! The parser, tobj, fails where only some corners of a group have texture coordinates, and repeats a group's name for each
//! change of material. It therefore reads a file that is written again: the vertices that some parts use, then one group for
//! each [`FaceGroup`]. Large files become several such texts, which are parsed at the same time.
//!
//! Measure: lines and indices count from 1, as in the file; colours of vertices are sRGB values.
//! Range: a text holds each vertex once, so that vertices which several texts use are parsed several times.
//! Source: the OBJ format, appendix B1 of Wavefront's Advanced Visualizer manual. Tested in `lines`.

use std::borrow::Cow;
use std::fmt::Write;
use std::ops::Range;

/// Indices of a vertex, texture coordinate and normal, counted from 1; 0 is none.
pub type Corner = [u32; 3];

/// A checked OBJ file.
#[derive(Debug, Default)]
pub struct ObjText<'a> {
    /// The lines of all vertices, texture coordinates and normals, in this order.
    pub vertices: [Vec<Cow<'a, str>>; 3],
    /// All faces, grouped by part.
    pub parts: Vec<FaceGroup>,
    /// The names given by `o` and `g`.
    pub groups: Vec<String>,
    /// The files named by `mtllib`, with their lines.
    pub libraries: Vec<(usize, String)>,
    /// The materials named by `usemtl`, each with its first line.
    pub materials: Vec<(usize, String)>,
    /// Number of points and lines that were left out.
    pub left_out: usize,
    /// The colours of vertices, with the numbers of the vertices, counted from 0.
    pub colours: Vec<(usize, [f32; 3])>,
}

/// The faces of one group and one material, with texture coordinates and normals for all corners or for none.
#[derive(Debug)]
pub struct FaceGroup {
    /// Index into [`ObjText::groups`]; `None` before the first group.
    pub group: Option<usize>,
    /// Index into [`ObjText::materials`].
    pub material: Option<usize>,
    /// The line of the first face.
    pub line: usize,
    /// Whether the corners have texture coordinates and normals.
    pub complete: [bool; 2],
    /// The number of corners of each face.
    pub arities: Vec<usize>,
    /// The corners of all faces.
    pub corners: Vec<Corner>,
    /// The vertices, texture coordinates and normals that the faces use, counted from 0.
    pub used: [Range<usize>; 3],
}

/// Some parts, and the vertices, texture coordinates and normals that they use, counted from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// Indices into [`ObjText::parts`].
    pub parts: Range<usize>,
    used: [Range<usize>; 3],
}

impl ObjText<'_> {
    /// The number of vertices with a colour.
    pub fn coloured(&self) -> usize {
        self.colours.len()
    }

    /// Whether vertices have colours, all of them within [0, 1].
    pub fn has_valid_colours(&self) -> bool {
        let is_valid = |colour: &[f32; 3]| colour.iter().all(|x| (0.0..=1.0).contains(x));
        !self.colours.is_empty() && self.colours.iter().all(|(_, colour)| is_valid(colour))
    }

    /// Divides the parts into batches, each of at least `work` vertices and corners and with the vertices that it uses. Parts
    /// that share most of their vertices with others stay in one batch, as the parser would read these vertices once for each.
    pub fn batches(&self, work: usize) -> Vec<Batch> {
        let mut batches: Vec<Batch> = Vec::new();
        let mut done = work;
        for (index, part) in self.parts.iter().enumerate() {
            if done >= work {
                done = 0;
                batches.push(Batch {
                    parts: index..index,
                    used: Default::default(),
                });
            }
            let batch = batches.last_mut().expect("the first part begins a batch");
            batch.parts.end = index + 1;
            for (used, by_part) in batch.used.iter_mut().zip(&part.used) {
                *used = union(used, by_part);
            }
            done += part.work();
        }
        let read = |batch: &Batch| batch.used.iter().map(Range::len).sum::<usize>();
        let vertices: usize = self.vertices.iter().map(Vec::len).sum();
        if batches.iter().map(read).sum::<usize>() > vertices + vertices / 4 {
            return vec![Batch {
                parts: 0..self.parts.len(),
                used: self.vertices.each_ref().map(|lines| 0..lines.len()),
            }];
        }
        batches
    }

    /// An estimate of the bytes that a batch takes as text, without colours.
    fn text_size(&self, batch: &Batch) -> usize {
        let lines = self.vertices.iter().zip(&batch.used);
        let lines = lines.flat_map(|(lines, used)| &lines[used.clone()]);
        let vertices: usize = lines.map(|line| line.len() + 1).sum();
        let parts = self.parts[batch.parts.clone()].iter();
        vertices + parts.map(FaceGroup::text_size).sum::<usize>()
    }

    /// Returns the text of a batch for the parser, which finds one model per part, in their order, with the colours of vertices
    /// if they are wanted.
    pub fn for_parser(&self, batch: &Batch, with_colours: bool) -> String {
        let mut text = String::with_capacity(self.text_size(batch));
        let [used, uvs, normals] = &batch.used;
        let before = self.colours.partition_point(|(of, _)| *of < used.start);
        let mut colours = self.colours[before..].iter().peekable();
        for vertex in used.clone() {
            text.push_str(&self.vertices[0][vertex]);
            if with_colours {
                let colour = colours.next_if(|(of, _)| *of == vertex);
                let [r, g, b] = colour.map_or([1.0; 3], |(_, colour)| *colour);
                write!(text, " {r:e} {g:e} {b:e}").expect(INFALLIBLE);
            }
            text.push('\n');
        }
        let others =
            [(1, uvs), (2, normals)].map(|(kind, used)| &self.vertices[kind][used.clone()]);
        for line in others.into_iter().flatten() {
            text.push_str(line);
            text.push('\n');
        }
        let first = batch.used.each_ref().map(|used| used.start);
        for index in batch.parts.clone() {
            writeln!(text, "g {index}").expect(INFALLIBLE);
            self.parts[index].write_faces(&mut text, first);
        }
        text
    }
}

impl FaceGroup {
    /// An estimate of the bytes that the faces take as text.
    fn text_size(&self) -> usize {
        let [uvs, normals] = self.complete.map(usize::from);
        7 * self.corners.len() * (1 + uvs + normals)
    }

    /// The work of the parser, as a number of lines and corners.
    fn work(&self) -> usize {
        self.corners.len() + self.used.iter().map(Range::len).sum::<usize>()
    }

    /// Appends the lines of the faces, with indices that count from `first`.
    fn write_faces(&self, text: &mut String, first: [usize; 3]) {
        let [has_uv, has_normal] = self.complete;
        let indices = [
            (0, " ", true),
            (1, "/", has_uv),
            (2, if has_uv { "/" } else { "//" }, has_normal),
        ];
        let mut digits = itoa::Buffer::new();
        let mut corners = self.corners.iter();
        for &arity in &self.arities {
            text.push('f');
            for corner in corners.by_ref().take(arity) {
                for (kind, separator, _) in indices.iter().filter(|(.., is_written)| *is_written) {
                    text.push_str(separator);
                    text.push_str(digits.format(corner[*kind] as usize - first[*kind]));
                }
            }
            text.push('\n');
        }
    }
}

/// Returns the smallest range that holds two others, of which one may be empty.
pub fn union(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    if a.is_empty() {
        b.clone()
    } else if b.is_empty() {
        a.clone()
    } else {
        a.start.min(b.start)..a.end.max(b.end)
    }
}

const INFALLIBLE: &str = "writing to a string does not fail";
