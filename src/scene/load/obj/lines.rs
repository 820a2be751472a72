//! Parses the lines of an OBJ file, and sorts its faces into parts.
//!
//! Large files are cut into chunks, which are parsed at the same time.
//!
//! Measure: lines and indices count from 1, as in the file; colours of vertices are sRGB values.
//! Range: errors have their line. Repaired: points and lines are left out; weights of vertices are dropped; a vertex without
//! a colour is white where others have one; a missing second texture coordinate is 0; a face of which only some corners have
//! texture coordinates or normals loses them. Other keywords are ignored.
//! Source: the OBJ format, appendix B1 of Wavefront's Advanced Visualizer manual. Tested below.

use super::super::wording::LineError;
use super::chunks::{chunks, logical_lines};
use super::model::{FaceGroup, FaceList, ObjModel};
use super::vertices::Corner;
use super::words::{KINDS, corner, numbers};
use crate::math::vec::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// The largest number of vertices, texture coordinates, normals, or corners of a part, as meshes number vertices in 32 bits.
const MAX_VERTICES: usize = u32::MAX as usize;

/// Group, material, and whether all corners have texture coordinates and normals.
type PartKey = (Option<usize>, Option<usize>, [bool; 2]);

/// Size of the chunks in bytes: some milliseconds of work.
const CHUNK_SIZE: usize = 1 << 20;

/// Reads all lines; those of groups and materials are ignored if `is_whole`.
///
/// # Errors
/// The first invalid line.
pub fn read(text: &str, is_whole: bool) -> Result<ObjModel, LineError> {
    read_in_chunks(text, is_whole, CHUNK_SIZE)
}

fn read_in_chunks(text: &str, is_whole: bool, size: usize) -> Result<ObjModel, LineError> {
    let chunks = chunks(text, size);
    let (_, all_but_last) = chunks.split_last().expect("there is a chunk of any text");
    let counts: Vec<Position> = all_but_last.par_iter().map(|chunk| count(chunk)).collect();
    let mut position = Position {
        line: 1,
        vertices: [0; 3],
    };
    let mut starts = vec![position];
    for count in counts {
        position.line += count.line;
        for (all, more) in position.vertices.iter_mut().zip(count.vertices) {
            *all += more;
        }
        starts.push(position);
    }
    let parsed: Vec<Result<ObjParser, LineError>> = chunks
        .par_iter()
        .zip(starts)
        .map(|(chunk, start)| ObjParser::of_chunk(chunk, start, is_whole))
        .collect();
    let parsed = parsed.into_iter().collect::<Result<Vec<_>, _>>()?;
    let counts = [0, 1, 2].map(|kind| parsed.iter().map(|it| it.obj.counts()[kind]).sum());
    let mut parsed = parsed.into_iter();
    let mut whole = parsed.next().expect("there is a chunk of any text");
    whole.obj.reserve(counts);
    for next in parsed {
        whole.append(next);
    }
    let too_long = |part: &&FaceGroup| part.corner_count() > MAX_VERTICES;
    if let Some(part) = whole.obj.parts.iter().find(too_long) {
        let why = format!("too many faces of one part: at most {MAX_VERTICES} corners");
        return Err((part.line, why));
    }
    Ok(whole.obj)
}

/// A place in the file: a line, and the number of each of [`KINDS`] before it.
#[derive(Debug, Clone, Copy, Default)]
struct Position {
    line: usize,
    vertices: [usize; 3],
}

/// Counts the lines and vertices of a chunk.
fn count(chunk: &str) -> Position {
    let mut vertices = [0; 3];
    for (_, content) in logical_lines(chunk, 0) {
        match content.split_ascii_whitespace().next() {
            Some("v") => vertices[0] += 1,
            Some("vt") => vertices[1] += 1,
            Some("vn") => vertices[2] += 1,
            _ => {}
        }
    }
    Position {
        line: memchr::memchr_iter(b'\n', chunk.as_bytes()).count(),
        vertices,
    }
}

/// The parser's state between the lines of a chunk.
#[derive(Default)]
struct ObjParser {
    obj: ObjModel,
    /// Whether groups and materials are ignored.
    is_whole: bool,
    /// The number of each of [`KINDS`] before the chunk.
    before: [usize; 3],
    /// The current group; `None` is that of the chunk before.
    group: Option<usize>,
    groups: HashMap<String, usize>,
    /// The current material; `None` is that of the chunk before.
    material: Option<usize>,
    materials: HashMap<String, usize>,
    parts: HashMap<PartKey, usize>,
    /// The part of the current group and material, for faces with or without texture coordinates and normals.
    current: [[Option<usize>; 2]; 2],
    corners: Vec<Corner>,
}

impl ObjParser {
    fn of_chunk(chunk: &str, start: Position, is_whole: bool) -> Result<Self, LineError> {
        let mut parser = Self {
            is_whole,
            before: start.vertices,
            ..Self::default()
        };
        for (line, content) in logical_lines(chunk, start.line) {
            parser.read(line, &content).map_err(|why| (line, why))?;
        }
        Ok(parser)
    }

    /// Appends what the next chunk holds.
    fn append(&mut self, next: Self) {
        let obj = next.obj;
        let groups: Vec<usize> = obj.groups.iter().map(|name| self.add_group(name)).collect();
        let materials = obj.materials.iter();
        let materials: Vec<usize> = materials
            .map(|(line, name)| self.add_material(*line, name))
            .collect();
        for part in obj.parts {
            let group = part.group.map(|group| groups[group]).or(self.group);
            let material = part.material.map(|name| materials[name]).or(self.material);
            let index = self.add_part((group, material, part.complete), part.line);
            let whole = &mut self.obj.parts[index];
            whole.faces.extend(part.faces);
        }
        self.group = next.group.map(|group| groups[group]).or(self.group);
        self.material = next.material.map(|name| materials[name]).or(self.material);
        self.obj.positions.extend(obj.positions);
        self.obj.uvs.extend(obj.uvs);
        self.obj.normals.extend(obj.normals);
        self.obj.libraries.extend(obj.libraries);
        self.obj.colours.extend(obj.colours);
        self.obj.left_out += obj.left_out;
    }

    fn read(&mut self, line: usize, content: &str) -> Result<(), String> {
        let mut words = content.split_ascii_whitespace();
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        match keyword {
            "v" => self.position(words),
            "vt" => self.uv(words),
            "vn" => self.normal(words),
            "f" => self.face(line, words),
            "p" | "l" => {
                self.obj.left_out += 1;
                Ok(())
            }
            _ if self.is_whole => Ok(()),
            _ => self.name(
                line,
                keyword,
                content.trim_ascii_start()[keyword.len()..].trim(),
            ),
        }
    }

    /// Reads the name of a group, material or library.
    fn name(&mut self, line: usize, keyword: &str, name: &str) -> Result<(), String> {
        match keyword {
            "o" | "g" => {
                self.group = Some(self.add_group(name));
                self.current = Default::default();
            }
            "usemtl" if name.is_empty() => return Err("usemtl without a name".to_owned()),
            "usemtl" => {
                self.material = Some(self.add_material(line, name));
                self.current = Default::default();
            }
            "mtllib" if name.is_empty() => return Err("mtllib without a file".to_owned()),
            "mtllib" => self.obj.libraries.push((line, name.to_owned())),
            _ => {}
        }
        Ok(())
    }

    /// Returns the index of a group, which is added if it is new.
    fn add_group(&mut self, name: &str) -> usize {
        let next = self.groups.len();
        let index = *self.groups.entry(name.to_owned()).or_insert(next);
        if index == next {
            self.obj.groups.push(name.to_owned());
        }
        index
    }

    /// Returns the index of a material, which is added if it is new.
    fn add_material(&mut self, line: usize, name: &str) -> usize {
        let next = self.materials.len();
        let index = *self.materials.entry(name.to_owned()).or_insert(next);
        if index == next {
            self.obj.materials.push((line, name.to_owned()));
        }
        index
    }

    /// Adds a position, and the colour that may follow it.
    fn position<'b>(&mut self, mut words: impl Iterator<Item = &'b str>) -> Result<(), String> {
        let index = self.next_index(0)?;
        let position = numbers("v", &mut words, 3)?;
        self.obj.positions.push(DVec3::from_array(position));
        // Either a weight follows the coordinates, or red, green and blue.
        let mut more = words.map_while(|word| word.parse::<f64>().ok());
        if let (Some(r), Some(g), Some(b)) = (more.next(), more.next(), more.next()) {
            self.obj.colours.push((index, [r, g, b]));
        }
        Ok(())
    }

    /// Adds texture coordinates.
    fn uv<'b>(&mut self, mut words: impl Iterator<Item = &'b str>) -> Result<(), String> {
        self.next_index(1)?;
        let uv = numbers("vt", &mut words, 1)?;
        self.obj.uvs.push(DVec2::from_array(uv));
        Ok(())
    }

    /// Adds a normal.
    fn normal<'b>(&mut self, mut words: impl Iterator<Item = &'b str>) -> Result<(), String> {
        self.next_index(2)?;
        let normal = numbers("vn", &mut words, 3)?;
        self.obj.normals.push(DVec3::from_array(normal));
        Ok(())
    }

    /// Returns the number of each of [`KINDS`] up to here.
    fn counts(&self) -> [usize; 3] {
        let here = self.obj.counts();
        std::array::from_fn(|kind| self.before[kind] + here[kind])
    }

    /// Returns the index of the next one of a kind, counted from 0.
    fn next_index(&self, kind: usize) -> Result<usize, String> {
        match self.counts()[kind] {
            MAX_VERTICES => Err(format!("too many {}s: at most {MAX_VERTICES}", KINDS[kind])),
            index => Ok(index),
        }
    }

    /// Adds a face to its part.
    fn face<'b>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = &'b str>,
    ) -> Result<(), String> {
        let counts = self.counts();
        self.corners.clear();
        for word in words {
            self.corners.push(corner(word, &counts)?);
        }
        match self.corners.len() {
            0 => return Err("a face without vertices".to_owned()),
            1 | 2 => {
                self.obj.left_out += 1;
                return Ok(());
            }
            _ => {}
        }
        let complete = [1, 2].map(|kind| self.corners.iter().all(|corner| corner[kind] != 0));
        let part = self.part(line, complete);
        let part = &mut self.obj.parts[part];
        if part.faces.is_empty() {
            part.faces.push(FaceList::default());
        }
        let list = part.faces.last_mut().expect("there is a list now");
        list.push(&self.corners, complete);
        Ok(())
    }

    /// Returns the part of the current group and material for faces with these attributes.
    fn part(&mut self, line: usize, complete: [bool; 2]) -> usize {
        let [has_uv, has_normal] = complete.map(usize::from);
        if let Some(part) = self.current[has_uv][has_normal] {
            return part;
        }
        let part = self.add_part((self.group, self.material, complete), line);
        self.current[has_uv][has_normal] = Some(part);
        part
    }

    /// Returns the index of a part, which is added if it is new.
    fn add_part(&mut self, key: PartKey, line: usize) -> usize {
        *self.parts.entry(key).or_insert_with(|| {
            let (group, material, complete) = key;
            self.obj.parts.push(FaceGroup {
                group,
                material,
                line,
                complete,
                faces: Vec::new(),
            });
            self.obj.parts.len() - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    fn read(text: &str) -> ObjModel {
        super::read(text, false).expect(text)
    }

    fn corners(part: &FaceGroup) -> Vec<Corner> {
        let of_list = |list: &FaceList| {
            (0..list.corners[0].len())
                .map(|index| list.corner(index))
                .collect()
        };
        part.faces
            .iter()
            .map(of_list)
            .collect::<Vec<Vec<_>>>()
            .concat()
    }

    #[test]
    fn faces_are_split_by_group_material_and_vertex_attributes() {
        let text = format!(
            "{VERTICES}vt 0\nvn 0 0 1\ng a\nf 1 2 3\nf 1/1 2/1 3/1\nusemtl m\nf 1//1 2//1 3//1\n\
             g b\nf -3/-1/-1 -2/1/1 -1/1/1\nf 1 2\np 1\ng a\nusemtl m\nf 1//1 2//1 3//1\nf 1/1 2 3/1/\n",
        );
        let obj = read(&text);
        let parts: Vec<_> = obj
            .parts
            .iter()
            .map(|p| (p.group, p.material, p.line))
            .collect();
        let expected = [
            (Some(0), None, 7),
            (Some(0), None, 8),
            (Some(0), Some(0), 10),
            (Some(1), Some(0), 12),
            (Some(0), Some(0), 18),
        ];
        assert_eq!(parts, expected);
        assert_eq!(obj.groups, ["a", "b"]);
        assert_eq!(obj.left_out, 2);
        assert_eq!(obj.materials, [(9, "m".to_owned())]);
        let corners: Vec<_> = obj.parts.iter().map(corners).collect();
        let expected: [&[Corner]; 5] = [
            &[[1, 0, 0], [2, 0, 0], [3, 0, 0]],
            &[[1, 1, 0], [2, 1, 0], [3, 1, 0]],
            &[[1, 0, 1], [2, 0, 1], [3, 0, 1]].repeat(2),
            &[[1, 1, 1], [2, 1, 1], [3, 1, 1]],
            // Some corners have texture coordinates: the part has none.
            &[[1, 0, 0], [2, 0, 0], [3, 0, 0]],
        ];
        assert_eq!(corners, expected);
        assert!(obj.mesh(&obj.parts[4], false).mesh.uvs.is_empty());
        assert_eq!(obj.uvs, [DVec2::ZERO]);
    }

    #[test]
    fn a_part_has_a_vertex_for_each_different_corner() {
        let text = format!(
            "{VERTICES}v 1 1 0\nvt .25 .5\nvt 1 0\nvn 0 0 1\nvn 0 0 2\n\
             f 3/1/1 4/2/1 2/1/2\nf 2/1/2 4/2/2 3/1/1\ng b\nf 2 4 3 1\n"
        );
        let obj = read(&text);
        let first = obj.mesh(&obj.parts[0], false).mesh;
        let [b, c, d] = [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        assert_eq!(first.indices, [[0, 1, 2], [2, 3, 0]]);
        assert_eq!(first.positions, [c, d, b, d]);
        let [u, v] = [DVec2::new(0.25, 0.5), DVec2::X];
        assert_eq!(first.uvs, [u, v, u, v]);
        assert_eq!(first.normals, [1.0, 1.0, 2.0, 2.0].map(|z| DVec3::Z * z));
        let second = obj.mesh(&obj.parts[1], false).mesh;
        assert_eq!(second.indices, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(second.positions, [b, d, c, DVec3::ZERO]);
        assert!(second.uvs.is_empty() && second.normals.is_empty());
    }

    fn without_faces(mut obj: ObjModel) -> String {
        obj.parts.iter_mut().for_each(|part| part.faces.clear());
        format!("{obj:?}")
    }

    #[test]
    fn chunks_of_a_file_give_what_the_whole_file_gives() {
        let text = format!(
            "{VERTICES}mtllib l\nf 1 2 3\n# \\\ng a\nv 0 0 \\\n1 \\\r\n.5 .5 1\nusemtl m\n\nf -1 \\\n2 3\nvt 0\nl 1 2\n\
             f 1/1 2/1 3/-1\nusemtl n\nf 1 2 4\ng b\nf 1 2 4\ng a\nusemtl m\nf 4 3 2 1\nvn 0 0 1 \\\n\nf 1//1 2//1 3//1"
        );
        let whole = read(&text);
        assert!(whole.parts.len() == 6 && whole.colours == [(3, [0.5, 0.5, 1.0])]);
        let invalid = format!("{text}\nf 1 2 5");
        for size in 0..text.len() {
            let in_chunks = read_in_chunks(&text, false, size).expect(&text);
            for (part, expected) in in_chunks.parts.iter().zip(&whole.parts) {
                assert_eq!(corners(part), corners(expected), "{size}");
            }
            assert_eq!(
                without_faces(in_chunks),
                without_faces(read(&text)),
                "{size}"
            );
            let (line, _) = read_in_chunks(&invalid, false, size).expect_err(&invalid);
            assert_eq!(line, 28, "{size}");
        }
        assert!(chunks(&text, 0).len() > 10);
    }

    #[test]
    fn vertex_colours_are_kept_and_other_extra_components_dropped() {
        let text = "v 1 2 3 0\nv 1 2 3 .5 .25 1 7\nv 1 2 3 1 1\nvt 1 2 3\nf 1 2 3\n";
        let obj = read(text);
        assert!(obj.colours.len() == 1 && obj.has_valid_colours());
        let part = obj.mesh(&obj.parts[0], true);
        assert_eq!(part.mesh.positions, [DVec3::new(1.0, 2.0, 3.0); 3]);
        assert_eq!(part.colours, [[1.0; 3], [0.5, 0.25, 1.0], [1.0; 3]]);
        assert_eq!(obj.uvs, [DVec2::new(1.0, 2.0)]);
        for wrong in ["v 1 2 3 255 0 0\n", "v 1 2 3 -1 0 0\n", "v 1 2 3 nan 0 0\n"] {
            let obj = read(wrong);
            assert!(
                obj.colours.len() == 1 && !obj.has_valid_colours(),
                "{wrong}"
            );
        }
    }

    #[test]
    fn names_may_contain_spaces_and_lines_may_be_continued() {
        let lines = "  usemtl\ta b \nf 1 \\\r\n2 \\\n3\n# C:\\\nmtllib c d.mtl\nf 1 2 3 \\";
        let text = format!("{VERTICES}{lines}");
        let obj = read(&text);
        assert_eq!(obj.materials, [(4, "a b".to_owned())]);
        assert_eq!(obj.libraries, [(9, "c d.mtl".to_owned())]);
        assert_eq!(
            corners(&obj.parts[0]),
            [[1, 0, 0], [2, 0, 0], [3, 0, 0]].repeat(2)
        );
    }

    #[test]
    fn parse_errors_report_line_and_cause() {
        for (end, words) in [
            ("f 1 2 4", "vertex 4 is out of range: there are 3"),
            ("f 0 1 2", "vertex 0 is out of range"),
            ("f -4 1 2", "vertex -4 is out of range"),
            ("f 1 2 2147483648", "out of range"),
            ("f 1 2 -9223372036854775808", "out of range"),
            (
                "f 1 2 99999999999999999999",
                "expected the number of a vertex",
            ),
            (
                "f 1/1 2/1 3/1",
                "texture coordinate 1 is out of range: there are 0",
            ),
            ("f 1//1 2 3", "normal 1 is out of range"),
            ("f 1/// 2 3", "too many slashes"),
            ("f /1 2 3", "expected the number of a vertex, found ``"),
            ("f f", "expected the number of a vertex"),
            ("f", "a face without vertices"),
            ("v 1 2", "`v` needs 3 numbers, found 2"),
            ("vt", "`vt` needs 1 numbers, found 0"),
            ("v 1 nan 2", "expected a finite number, found `nan`"),
            ("v 1 1e999 2", "expected a finite number, found `1e999`"),
            ("vn 1 - 2", "expected a finite number, found `-`"),
            ("vt 1.2.3", "expected a finite number, found `1.2.3`"),
            ("usemtl", "usemtl without a name"),
            ("mtllib ", "mtllib without a file"),
        ] {
            let (line, why) = super::read(&format!("{VERTICES}{end}"), false).expect_err(end);
            assert_eq!(line, 4, "{end}");
            assert!(why.contains(words), "{end}: {why}");
        }
    }
}
