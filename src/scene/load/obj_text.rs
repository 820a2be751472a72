//! Checks the lines of an OBJ file, and sorts them into parts that the parser reads safely.
//!
//! The parser, tobj, does not report lines and accepts numbers that are not finite. It also fails where only some
//! corners of a group have texture coordinates, and repeats a group's name for each change of material. This pass
//! therefore checks every line and rewrites the file: first all vertices, then one group for each [`FaceGroup`].
//!
//! Measure: lines and indices count from 1, as in the file; colours of vertices are sRGB values.
//! Range: errors have their line. Repaired: points and lines are left out; weights of vertices are dropped; a vertex without
//! a colour is white where others have one; a missing second texture coordinate is 0; a face of which only some corners have
//! texture coordinates or normals loses them. Other keywords are ignored.
//! Source: the OBJ format, appendix B1 of Wavefront's Advanced Visualizer manual. Tested below.

use super::wording::{LineError, shown};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Write;

/// A checked OBJ file.
#[derive(Debug, Default)]
pub struct ObjText {
    /// The lines of all vertices, texture coordinates and normals.
    vertices: String,
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
    colours: Vec<(usize, [f32; 3])>,
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
    /// The faces, with indices that count from the start of the file.
    faces: String,
}

impl ObjText {
    /// Reads all lines.
    ///
    /// # Errors
    /// The first invalid line.
    pub fn read(text: &str) -> Result<Self, LineError> {
        Self::read_by(ObjParser::default(), text)
    }

    /// Reads all lines but those of groups and materials.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_whole(text: &str) -> Result<Self, LineError> {
        let reader = ObjParser {
            is_whole: true,
            ..ObjParser::default()
        };
        Self::read_by(reader, text)
    }

    fn read_by(mut reader: ObjParser, text: &str) -> Result<Self, LineError> {
        for (line, content) in logical_lines(text) {
            reader.read(line, &content).map_err(|why| (line, why))?;
        }
        Ok(reader.obj)
    }

    /// The number of vertices with a colour.
    pub fn coloured(&self) -> usize {
        self.colours.len()
    }

    /// Whether vertices have colours, all of them within [0, 1].
    pub fn has_valid_colours(&self) -> bool {
        let is_valid = |colour: &[f32; 3]| colour.iter().all(|x| (0.0..=1.0).contains(x));
        !self.colours.is_empty() && self.colours.iter().all(|(_, colour)| is_valid(colour))
    }

    /// Returns the text for the parser, which finds one model per part, in their order, with the colours of vertices if they
    /// are wanted.
    pub fn for_parser(&mut self, with_colours: bool) -> String {
        let mut text = std::mem::take(&mut self.vertices);
        if with_colours {
            text = coloured(&text, &self.colours);
        }
        for (index, part) in self.parts.iter_mut().enumerate() {
            write!(text, "g {index}\n{}", std::mem::take(&mut part.faces)).expect(INFALLIBLE);
        }
        text
    }
}

/// Returns the lines of vertices with their colours; vertices without one are white.
fn coloured(lines: &str, colours: &[(usize, [f32; 3])]) -> String {
    let mut text = String::with_capacity(2 * lines.len());
    let mut colours = colours.iter().peekable();
    let mut vertex = 0;
    for line in lines.lines() {
        text.push_str(line);
        if line.starts_with("v ") {
            let colour = colours.next_if(|(of, _)| *of == vertex);
            let [r, g, b] = colour.map_or([1.0; 3], |(_, colour)| *colour);
            write!(text, " {r:e} {g:e} {b:e}").expect(INFALLIBLE);
            vertex += 1;
        }
        text.push('\n');
    }
    text
}

const INFALLIBLE: &str = "writing to a string does not fail";

/// The attributes that a face's corner refers to.
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Indices of a vertex, texture coordinate and normal, counted from 1; 0 is none.
type Corner = [usize; 3];

/// Group, material, and whether all corners have texture coordinates and normals.
type PartKey = (Option<usize>, Option<usize>, [bool; 2]);

/// The parser's state between lines.
#[derive(Default)]
struct ObjParser {
    obj: ObjText,
    /// Whether groups and materials are ignored.
    is_whole: bool,
    /// The number of each of [`KINDS`] so far.
    counts: [usize; 3],
    group: Option<usize>,
    groups: HashMap<String, usize>,
    material: Option<usize>,
    materials: HashMap<String, usize>,
    parts: HashMap<PartKey, usize>,
    /// The part of the current group and material, for faces with or without texture coordinates and normals.
    current: [[Option<usize>; 2]; 2],
    corners: Vec<Corner>,
}

impl ObjParser {
    fn read(&mut self, line: usize, content: &str) -> Result<(), String> {
        let mut words = content.split_ascii_whitespace();
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        match keyword {
            "v" => self.vertex(0, "v", words, 3),
            "vt" => self.vertex(1, "vt", words, 1),
            "vn" => self.vertex(2, "vn", words, 3),
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
                let next = self.groups.len();
                self.group = Some(*self.groups.entry(name.to_owned()).or_insert(next));
                if self.group == Some(next) {
                    self.obj.groups.push(name.to_owned());
                }
                self.current = Default::default();
            }
            "usemtl" if name.is_empty() => return Err("usemtl without a name".to_owned()),
            "usemtl" => {
                let next = self.materials.len();
                self.material = Some(*self.materials.entry(name.to_owned()).or_insert(next));
                if self.material == Some(next) {
                    self.obj.materials.push((line, name.to_owned()));
                }
                self.current = Default::default();
            }
            "mtllib" if name.is_empty() => return Err("mtllib without a file".to_owned()),
            "mtllib" => self.obj.libraries.push((line, name.to_owned())),
            _ => {}
        }
        Ok(())
    }

    /// Copies the supported coordinates of a vertex, texture coordinate or normal.
    fn vertex<'a>(
        &mut self,
        kind: usize,
        keyword: &str,
        mut words: impl Iterator<Item = &'a str>,
        least: usize,
    ) -> Result<(), String> {
        let most = least.max(2);
        let mut found = 0;
        self.obj.vertices.push_str(keyword);
        for word in words.by_ref().take(most) {
            // 1e999 parses as infinity.
            if !word.parse().is_ok_and(f64::is_finite) {
                return Err(format!("expected a finite number, found `{}`", shown(word)));
            }
            self.obj.vertices.push(' ');
            self.obj.vertices.push_str(word);
            found += 1;
        }
        if found < least {
            return Err(format!("`{keyword}` needs {least} numbers, found {found}"));
        }
        for _ in found..most {
            self.obj.vertices.push_str(" 0");
        }
        self.obj.vertices.push('\n');
        // Either a weight follows the coordinates, or red, green and blue.
        let mut more = words.map_while(|word| word.parse::<f32>().ok());
        if kind == 0
            && let (Some(r), Some(g), Some(b)) = (more.next(), more.next(), more.next())
        {
            self.obj.colours.push((self.counts[0], [r, g, b]));
        }
        self.counts[kind] += 1;
        Ok(())
    }

    /// Adds a face to its part.
    fn face<'a>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), String> {
        self.corners.clear();
        for word in words {
            self.corners.push(corner(word, &self.counts)?);
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
        let faces = &mut self.obj.parts[part].faces;
        faces.push('f');
        let mut digits = itoa::Buffer::new();
        for &[v, vt, vn] in &self.corners {
            faces.push(' ');
            faces.push_str(digits.format(v));
            if complete[0] {
                faces.push('/');
                faces.push_str(digits.format(vt));
            }
            if complete[1] {
                faces.push_str(if complete[0] { "/" } else { "//" });
                faces.push_str(digits.format(vn));
            }
        }
        faces.push('\n');
        Ok(())
    }

    /// Returns the part of the current group and material for faces with these attributes.
    fn part(&mut self, line: usize, complete: [bool; 2]) -> usize {
        let current = &mut self.current[usize::from(complete[0])][usize::from(complete[1])];
        if let Some(part) = *current {
            return part;
        }
        let key = (self.group, self.material, complete);
        let part = *self.parts.entry(key).or_insert_with(|| {
            self.obj.parts.push(FaceGroup {
                group: self.group,
                material: self.material,
                line,
                faces: String::new(),
            });
            self.obj.parts.len() - 1
        });
        *current = Some(part);
        part
    }
}

/// Parses a face's corner: `v`, `v/vt`, `v//vn` or `v/vt/vn`. Negative indices count back from the last vertex so far.
fn corner(word: &str, counts: &[usize; 3]) -> Result<Corner, String> {
    let mut corner = [0; 3];
    // As a set of characters: a search for one character costs more in words so short.
    for (kind, part) in word.split(['/']).enumerate() {
        let Some(what) = KINDS.get(kind) else {
            return Err(format!("too many slashes in `{}`", shown(word)));
        };
        if part.is_empty() && kind > 0 {
            continue;
        }
        let number: i64 = part.parse().map_err(|_| {
            format!(
                "expected the number of a {what}, found `{}` in `{}`",
                shown(part),
                shown(word)
            )
        })?;
        let count = counts[kind];
        let distance = usize::try_from(number.unsigned_abs()).unwrap_or(usize::MAX);
        if !(1..=count).contains(&distance) {
            return Err(format!(
                "{what} {number} is out of range: there are {count} up to here, counted from 1"
            ));
        }
        corner[kind] = if number < 0 {
            count + 1 - distance
        } else {
            distance
        };
    }
    Ok(corner)
}

/// Returns the lines without comments, with their numbers; a line that ends in a backslash is joined with the next.
fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = (1..).zip(text.lines());
    std::iter::from_fn(move || {
        let (number, first) = lines
            .by_ref()
            .find(|(_, line)| !line.trim_ascii_start().starts_with('#'))?;
        let Some(part) = continued(first) else {
            return Some((number, Cow::Borrowed(first)));
        };
        // Appends in place: a file may be one line of a million parts.
        let mut whole = part.to_owned();
        for (_, next) in lines.by_ref() {
            whole.push(' ');
            let Some(part) = continued(next) else {
                whole.push_str(next);
                break;
            };
            whole.push_str(part);
        }
        Some((number, Cow::Owned(whole)))
    })
}

/// Returns the line without the backslash at its end; `None` if it has none.
fn continued(line: &str) -> Option<&str> {
    line.trim_ascii_end().strip_suffix('\\')
}

#[cfg(test)]
mod tests {
    use super::*;

    const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    fn read(end: &str) -> ObjText {
        ObjText::read(&format!("{VERTICES}{end}")).expect(end)
    }

    #[test]
    fn faces_are_split_by_group_material_and_vertex_attributes() {
        let mut obj = read(
            "vt 0\nvn 0 0 1\ng a\nf 1 2 3\nf 1/1 2/1 3/1\nusemtl m\nf 1//1 2//1 3//1\n\
             g b\nf -3/-1/-1 -2/1/1 -1/1/1\nf 1 2\np 1\ng a\nusemtl m\nf 1//1 2//1 3//1\nf 1/1 2 3/1/\n",
        );
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
        assert_eq!(
            obj.for_parser(false),
            format!(
                "{VERTICES}vt 0 0\nvn 0 0 1\ng 0\nf 1 2 3\ng 1\nf 1/1 2/1 3/1\n\
                 g 2\nf 1//1 2//1 3//1\nf 1//1 2//1 3//1\ng 3\nf 1/1/1 2/1/1 3/1/1\ng 4\nf 1 2 3\n"
            )
        );
    }

    #[test]
    fn vertex_colours_are_kept_and_other_extra_components_dropped() {
        let text = "v 1 2 3 0\nv 1 2 3 .5 .25 1 7\nv 1 2 3 1 1\nvt 1 2 3\n";
        let read = || ObjText::read(text).expect("valid");
        assert!(read().coloured() == 1 && read().has_valid_colours());
        assert_eq!(
            read().for_parser(false),
            "v 1 2 3\nv 1 2 3\nv 1 2 3\nvt 1 2\n"
        );
        assert_eq!(
            read().for_parser(true),
            "v 1 2 3 1e0 1e0 1e0\nv 1 2 3 5e-1 2.5e-1 1e0\nv 1 2 3 1e0 1e0 1e0\nvt 1 2\n"
        );
        for wrong in ["v 1 2 3 255 0 0\n", "v 1 2 3 -1 0 0\n", "v 1 2 3 nan 0 0\n"] {
            let obj = ObjText::read(wrong).expect(wrong);
            assert!(obj.coloured() == 1 && !obj.has_valid_colours(), "{wrong}");
        }
    }

    #[test]
    fn names_may_contain_spaces_and_lines_may_be_continued() {
        let obj = read("  usemtl\ta b \nf 1 \\\r\n2 \\\n3\n# C:\\\nmtllib c d.mtl\nf 1 2 3 \\");
        assert_eq!(obj.materials, [(4, "a b".to_owned())]);
        assert_eq!(obj.libraries, [(9, "c d.mtl".to_owned())]);
        assert_eq!(obj.parts[0].faces, "f 1 2 3\nf 1 2 3\n");
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
            ("usemtl", "usemtl without a name"),
            ("mtllib ", "mtllib without a file"),
        ] {
            let (line, why) = ObjText::read(&format!("{VERTICES}{end}")).expect_err(end);
            assert_eq!(line, 4, "{end}");
            assert!(why.contains(words), "{end}: {why}");
        }
    }
}
