//! What has to be right in an OBJ file before it is parsed: every error with its line.
//!
//! The parser itself, tobj, tells no lines, and takes faces without vertices or numbers that are not finite as they
//! come. This one pass over the lines makes sure that it gets neither.
//!
//! Measure: lines and indices count from 1, as in the file.
//! Range: `v`, `vt`, `vn`, `f`, `usemtl` and `mtllib` are checked; other keywords are passed over.
//! Source: the OBJ format of Wavefront's Advanced Visualizer manual, appendix B1. Tested below.

use super::reader::unknown_name;

/// A complaint: the line and what is wrong there.
pub type Complaint = (usize, String);

/// What the pass found on its way.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Facts {
    /// Material libraries, with their lines.
    pub libraries: Vec<(usize, String)>,
    /// Materials in use, each with the line of its first use.
    pub materials: Vec<(usize, String)>,
    /// Faces of three or more vertices.
    pub faces: usize,
    /// Faces of one or two vertices, points and lines: nothing to render.
    pub degenerate: usize,
}

/// Counts of what faces may refer to.
#[derive(Default)]
struct Counts {
    positions: i64,
    uvs: i64,
    normals: i64,
}

/// Checks every line.
pub fn check(text: &str) -> Result<Facts, Complaint> {
    let mut facts = Facts::default();
    let mut counts = Counts::default();
    for (line, content) in (1..).zip(text.lines()) {
        check_line(line, content, &mut facts, &mut counts).map_err(|why| (line, why))?;
    }
    Ok(facts)
}

/// Whether every material in use is among `known`.
pub fn check_materials(facts: &Facts, known: &[&str]) -> Result<(), Complaint> {
    match facts
        .materials
        .iter()
        .find(|(_, name)| !known.contains(&name.as_str()))
    {
        Some((line, name)) => Err((*line, unknown_name("material", name, known))),
        None => Ok(()),
    }
}

fn check_line(
    line: usize,
    content: &str,
    facts: &mut Facts,
    counts: &mut Counts,
) -> Result<(), String> {
    if content.trim_end().ends_with('\\') {
        return Err("lines that go on after a backslash are not supported".to_owned());
    }
    let mut words = content.split_whitespace();
    match words.next() {
        Some("v") => {
            counts.positions += 1;
            check_numbers("v", 3, words)
        }
        Some("vt") => {
            counts.uvs += 1;
            check_numbers("vt", 2, words)
        }
        Some("vn") => {
            counts.normals += 1;
            check_numbers("vn", 3, words)
        }
        Some("f") => {
            let mut corners = 0;
            for word in words {
                check_corner(word, counts)?;
                corners += 1;
            }
            match corners {
                0 => return Err("a face without vertices".to_owned()),
                1 | 2 => facts.degenerate += 1,
                _ => facts.faces += 1,
            }
            Ok(())
        }
        // tobj reads both as faces.
        Some("l" | "p") => {
            facts.degenerate += 1;
            words.try_for_each(|word| check_corner(word, counts))
        }
        Some("usemtl") => {
            let name = rest_of(content).ok_or("usemtl without a name")?;
            if !facts.materials.iter().any(|(_, known)| known == name) {
                facts.materials.push((line, name.to_owned()));
            }
            Ok(())
        }
        Some("mtllib") => {
            let name = rest_of(content).ok_or("mtllib without a file")?;
            facts.libraries.push((line, name.to_owned()));
            Ok(())
        }
        _ => Ok(()),
    }
}

/// What follows the keyword, which may contain spaces.
fn rest_of(content: &str) -> Option<&str> {
    let (_, rest) = content.trim().split_once(' ')?;
    Some(rest.trim()).filter(|rest| !rest.is_empty())
}

fn check_numbers<'a>(
    keyword: &str,
    count: usize,
    words: impl Iterator<Item = &'a str>,
) -> Result<(), String> {
    let mut found = 0;
    for word in words.take(count) {
        // 1e999 parses as infinity.
        if !word.parse().is_ok_and(f64::is_finite) {
            return Err(format!("expected a finite number, found `{word}`"));
        }
        found += 1;
    }
    if found == count {
        Ok(())
    } else {
        Err(format!("`{keyword}` needs {count} numbers, found {found}"))
    }
}

/// A face's corner: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn check_corner(word: &str, counts: &Counts) -> Result<(), String> {
    let kinds = [
        ("vertex", counts.positions),
        ("texture coordinate", counts.uvs),
        ("normal", counts.normals),
    ];
    let mut parts = word.split('/');
    for (index, ((what, count), part)) in kinds.into_iter().zip(parts.by_ref()).enumerate() {
        if part.is_empty() && index > 0 {
            continue;
        }
        let number: i64 = part
            .parse()
            .map_err(|_| format!("expected the number of a {what}, found `{part}` in `{word}`"))?;
        let in_range = (1..=count).contains(&number) || (-count..=-1).contains(&number);
        if !in_range {
            return Err(format!(
                "{what} {number} is out of range: there are {count} up to here, counted from 1"
            ));
        }
    }
    if parts.next().is_some() {
        Err(format!("too many slashes in `{word}`"))
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    fn complaint(end: &str) -> Complaint {
        check(&format!("{VERTICES}{end}")).expect_err(end)
    }

    #[test]
    fn faces_in_every_spelling_are_fine() {
        let text = format!(
            "{VERTICES}vt 0 0\nvn 0 0 1\nf 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf -3/-1/-1 -2/1/1 -1/1/1\nf 1 2\n"
        );
        let facts = check(&text).expect("all of it is fine");
        assert_eq!((facts.faces, facts.degenerate), (4, 1));
    }

    #[test]
    fn every_error_has_its_line() {
        for (end, words) in [
            ("f 1 2 4", "vertex 4 is out of range: there are 3"),
            ("f 0 1 2", "vertex 0 is out of range"),
            ("f -4 1 2", "vertex -4 is out of range"),
            ("f 1 2 2147483648", "out of range"),
            (
                "f 1 2 99999999999999999999",
                "expected the number of a vertex",
            ),
            (
                "f 1/1 2/1 3/1",
                "texture coordinate 1 is out of range: there are 0",
            ),
            ("f 1//1 2 3", "normal 1 is out of range"),
            ("f 1/1/1/1 2 3", "out of range"),
            ("f f", "expected the number of a vertex"),
            ("f", "a face without vertices"),
            ("v 1 2", "`v` needs 3 numbers, found 2"),
            ("v 1 nan 2", "expected a finite number, found `nan`"),
            ("v 1 1e999 2", "expected a finite number, found `1e999`"),
            ("usemtl", "usemtl without a name"),
            ("v 1 2 \\", "backslash"),
        ] {
            let (line, why) = complaint(end);
            assert_eq!(line, 4, "{end}");
            assert!(why.contains(words), "{end}: {why}");
        }
    }

    #[test]
    fn a_material_that_is_not_there_is_answered_with_the_nearest() {
        let facts = check("usemtl glas\n").expect("no faces, no errors");
        let (line, why) = check_materials(&facts, &["glass", "gold"]).expect_err("not there");
        assert_eq!(
            (line, why.as_str()),
            (1, "unknown material `glas`; did you mean `glass`?")
        );
    }
}
