//! Checks the lines of an OBJ file, and sorts its faces into parts.
//!
//! The parser, tobj, does not report lines and accepts numbers that are not finite, so this pass checks every line. Large
//! files are cut into chunks, which are checked at the same time.
//!
//! Measure: lines and indices count from 1, as in the file; colours of vertices are sRGB values.
//! Range: errors have their line. Repaired: points and lines are left out; weights of vertices are dropped; a vertex without
//! a colour is white where others have one; a missing second texture coordinate is 0; a face of which only some corners have
//! texture coordinates or normals loses them. Other keywords are ignored.
//! Source: the OBJ format, appendix B1 of Wavefront's Advanced Visualizer manual. Tested below.

use super::super::wording::{LineError, shown};
use super::chunks::{chunks, logical_lines};
use super::text::{Corner, FaceGroup, ObjText, union};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashMap;

/// The largest number of vertices, texture coordinates or normals: tobj numbers them in 32 bits.
const MAX_VERTICES: usize = u32::MAX as usize;

/// The attributes that a face's corner refers to.
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Group, material, and whether all corners have texture coordinates and normals.
type PartKey = (Option<usize>, Option<usize>, [bool; 2]);

/// Size of the chunks in bytes: some milliseconds of work.
const CHUNK_SIZE: usize = 1 << 20;

/// Reads all lines; those of groups and materials are ignored if `is_whole`.
///
/// # Errors
/// The first invalid line.
pub fn read(text: &str, is_whole: bool) -> Result<ObjText<'_>, LineError> {
    read_in_chunks(text, is_whole, CHUNK_SIZE)
}

fn read_in_chunks(text: &str, is_whole: bool, size: usize) -> Result<ObjText<'_>, LineError> {
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
    let mut parsed = parsed.into_iter();
    let mut whole = parsed.next().expect("there is a chunk of any text")?;
    for next in parsed {
        whole.append(next?);
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
        line: chunk.bytes().filter(|byte| *byte == b'\n').count(),
        vertices,
    }
}

/// The parser's state between the lines of a chunk.
#[derive(Default)]
struct ObjParser<'a> {
    obj: ObjText<'a>,
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

impl<'a> ObjParser<'a> {
    fn of_chunk(chunk: &'a str, start: Position, is_whole: bool) -> Result<Self, LineError> {
        let mut parser = Self {
            is_whole,
            before: start.vertices,
            ..Self::default()
        };
        for (line, content) in logical_lines(chunk, start.line) {
            parser.read(line, content).map_err(|why| (line, why))?;
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
            whole.arities.extend(part.arities);
            whole.corners.extend(part.corners);
            for (used, more) in whole.used.iter_mut().zip(&part.used) {
                *used = union(used, more);
            }
        }
        self.group = next.group.map(|group| groups[group]).or(self.group);
        self.material = next.material.map(|name| materials[name]).or(self.material);
        for (lines, more) in self.obj.vertices.iter_mut().zip(obj.vertices) {
            lines.extend(more);
        }
        self.obj.libraries.extend(obj.libraries);
        self.obj.colours.extend(obj.colours);
        self.obj.left_out += obj.left_out;
    }

    fn read(&mut self, line: usize, content: Cow<'a, str>) -> Result<(), String> {
        let mut words = content.split_ascii_whitespace();
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        match keyword {
            "v" => self.vertex(0, content, 3),
            "vt" => self.vertex(1, content, 1),
            "vn" => self.vertex(2, content, 3),
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

    /// Keeps the supported coordinates of a vertex, texture coordinate or normal.
    fn vertex(&mut self, kind: usize, content: Cow<'a, str>, least: usize) -> Result<(), String> {
        let mut words = content.split_ascii_whitespace();
        let keyword = words.next().unwrap_or_default();
        let most = least.max(2);
        let mut numbers = [""; 3];
        let mut found = 0;
        for word in words.by_ref().take(most) {
            if !is_finite_number(word) {
                return Err(format!("expected a finite number, found `{}`", shown(word)));
            }
            numbers[found] = word;
            found += 1;
        }
        if found < least {
            return Err(format!("`{keyword}` needs {least} numbers, found {found}"));
        }
        let lines = &mut self.obj.vertices[kind];
        let index = self.before[kind] + lines.len();
        if index == MAX_VERTICES {
            return Err(format!("too many {}s: at most {MAX_VERTICES}", KINDS[kind]));
        }
        let mut more = words.peekable();
        if found == most && more.peek().is_none() {
            lines.push(content);
            return Ok(());
        }
        // Either a weight follows the coordinates, or red, green and blue.
        let mut more = more.map_while(|word| word.parse::<f32>().ok());
        if kind == 0
            && let (Some(r), Some(g), Some(b)) = (more.next(), more.next(), more.next())
        {
            self.obj.colours.push((index, [r, g, b]));
        }
        let numbers = numbers[..most]
            .iter()
            .map(|word| if word.is_empty() { "0" } else { word });
        let line = [keyword]
            .into_iter()
            .chain(numbers)
            .collect::<Vec<_>>()
            .join(" ");
        lines.push(Cow::Owned(line));
        Ok(())
    }

    /// Adds a face to its part.
    fn face<'b>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = &'b str>,
    ) -> Result<(), String> {
        let counts: [usize; 3] =
            std::array::from_fn(|kind| self.before[kind] + self.obj.vertices[kind].len());
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
        part.arities.push(self.corners.len());
        part.corners.extend_from_slice(&self.corners);
        let is_used = [true, complete[0], complete[1]];
        for (kind, used) in part
            .used
            .iter_mut()
            .enumerate()
            .filter(|(kind, _)| is_used[*kind])
        {
            for corner in &self.corners {
                let index = corner[kind] as usize;
                *used = union(used, &(index - 1..index));
            }
        }
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
                arities: Vec::new(),
                corners: Vec::new(),
                used: Default::default(),
            });
            self.obj.parts.len() - 1
        })
    }
}

/// Whether a word is a number below infinity; 1e999 parses as infinity.
fn is_finite_number(word: &str) -> bool {
    let digits = word.strip_prefix(['+', '-']).unwrap_or(word);
    // Most numbers are short and have no exponent: these need no parsing.
    let (mut count, mut points) = (0, 0);
    let is_plain = digits.len() < 100
        && digits.bytes().all(|byte| {
            count += u32::from(byte.is_ascii_digit());
            points += u32::from(byte == b'.');
            byte.is_ascii_digit() || byte == b'.'
        });
    (is_plain && count > 0 && points <= 1) || word.parse().is_ok_and(f64::is_finite)
}

/// Parses a face's corner: `v`, `v/vt`, `v//vn` or `v/vt/vn`. Negative indices count back from the last vertex so far.
fn corner(word: &str, counts: &[usize; 3]) -> Result<Corner, String> {
    let mut corner = [0; 3];
    let mut rest = Some(word);
    for kind in 0.. {
        let Some(text) = rest else { break };
        let Some(what) = KINDS.get(kind) else {
            return Err(format!("too many slashes in `{}`", shown(word)));
        };
        let end = text.bytes().position(|byte| byte == b'/');
        let part = &text[..end.unwrap_or(text.len())];
        rest = end.map(|end| &text[end + 1..]);
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
        let index = if number < 0 {
            count + 1 - distance
        } else {
            distance
        };
        corner[kind] = u32::try_from(index).expect("at most MAX_VERTICES");
    }
    Ok(corner)
}

#[cfg(test)]
mod tests {
    use super::*;

    const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    fn read(text: &str) -> ObjText<'_> {
        super::read(text, false).expect(text)
    }

    /// Returns the texts for the parser, each of at least `work` vertices and corners.
    fn texts(obj: &ObjText, work: usize, with_colours: bool) -> Vec<String> {
        let batches = obj.batches(work);
        let text = |batch| obj.for_parser(batch, with_colours);
        batches.iter().map(text).collect()
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
        // The parts share their vertices, and therefore one text.
        let expected = format!(
            "{VERTICES}vt 0 0\nvn 0 0 1\ng 0\nf 1 2 3\ng 1\nf 1/1 2/1 3/1\n\
             g 2\nf 1//1 2//1 3//1\nf 1//1 2//1 3//1\ng 3\nf 1/1/1 2/1/1 3/1/1\ng 4\nf 1 2 3\n"
        );
        assert_eq!(texts(&obj, 1, false), [expected]);
    }

    #[test]
    fn parts_with_vertices_of_their_own_have_texts_of_their_own() {
        let text = format!(
            "{VERTICES}vn 0 0 1\ng a\nf 1 2 3\n{VERTICES}{VERTICES}vn 1 0 0\ng b\nf 8//2 9//2 7//2\nf -3 5 4\n"
        );
        let first = format!("{VERTICES}g 0\nf 1 2 3\n");
        let second = format!("{VERTICES}vn 1 0 0\ng 1\nf 2//1 3//1 1//1\n");
        let third = format!("{VERTICES}v 0 0 0\ng 2\nf 4 2 1\n");
        let obj = read(&text);
        assert_eq!(texts(&obj, 6, false), [first, second, third]);
        assert_eq!(texts(&obj, 100, false).len(), 1);
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
            assert_eq!(format!("{in_chunks:?}"), format!("{whole:?}"), "{size}");
            let (line, _) = read_in_chunks(&invalid, false, size).expect_err(&invalid);
            assert_eq!(line, 28, "{size}");
        }
        assert!(chunks(&text, 0).len() > 10);
    }

    #[test]
    fn vertex_colours_are_kept_and_other_extra_components_dropped() {
        let text = "v 1 2 3 0\nv 1 2 3 .5 .25 1 7\nv 1 2 3 1 1\nvt 1 2 3\nf 1 2 3\n";
        let obj = read(text);
        assert!(obj.coloured() == 1 && obj.has_valid_colours());
        assert_eq!(
            texts(&obj, 1, false),
            ["v 1 2 3\nv 1 2 3\nv 1 2 3\ng 0\nf 1 2 3\n"]
        );
        assert_eq!(
            texts(&obj, 1, true),
            ["v 1 2 3 1e0 1e0 1e0\nv 1 2 3 5e-1 2.5e-1 1e0\nv 1 2 3 1e0 1e0 1e0\ng 0\nf 1 2 3\n"]
        );
        for wrong in ["v 1 2 3 255 0 0\n", "v 1 2 3 -1 0 0\n", "v 1 2 3 nan 0 0\n"] {
            let obj = read(wrong);
            assert!(obj.coloured() == 1 && !obj.has_valid_colours(), "{wrong}");
        }
    }

    #[test]
    fn numbers_without_an_exponent_are_known_to_be_finite() {
        let long = "1".repeat(400);
        for (word, expected) in [
            ("1", true),
            ("-.5", true),
            ("+1.", true),
            ("1e-5", true),
            ("", false),
            (".", false),
            ("-", false),
            ("1.2.3", false),
            ("inf", false),
            ("1e999", false),
            (long.as_str(), false),
        ] {
            assert_eq!(is_finite_number(word), expected, "{word}");
            assert_eq!(word.parse().is_ok_and(f64::is_finite), expected, "{word}");
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
            obj.parts[0].corners,
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
            ("usemtl", "usemtl without a name"),
            ("mtllib ", "mtllib without a file"),
        ] {
            let (line, why) = super::read(&format!("{VERTICES}{end}"), false).expect_err(end);
            assert_eq!(line, 4, "{end}");
            assert!(why.contains(words), "{end}: {why}");
        }
    }
}
