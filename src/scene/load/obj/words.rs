//! Parses the words of an OBJ line: numbers, and the corners of faces.
//!
//! Measure: indices count from 1, as in the file.
//! Range: finite numbers; indices of vertices that come before the face. An error says what was expected.
//! Source: the OBJ format, appendix B1 of Wavefront's Advanced Visualizer manual. Tested in `lines`.

use super::super::wording::shown;
use super::vertices::Corner;

/// The attributes that a face's corner refers to.
pub const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Parses up to `N` finite numbers, of which at least `least` are given; all others are 0.
pub fn numbers<'a, const N: usize>(
    keyword: &str,
    words: &mut impl Iterator<Item = &'a str>,
    least: usize,
) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    for (found, number) in numbers.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            if found < least {
                return Err(format!("`{keyword}` needs {least} numbers, found {found}"));
            }
            break;
        };
        *number = word
            .parse()
            .ok()
            .filter(|x: &f64| x.is_finite())
            .ok_or_else(|| format!("expected a finite number, found `{}`", shown(word)))?;
    }
    Ok(numbers)
}

/// Parses a face's corner: `v`, `v/vt`, `v//vn` or `v/vt/vn`. Negative indices count back from the last vertex so far.
pub fn corner(word: &str, counts: &[usize; 3]) -> Result<Corner, String> {
    let mut corner = [0; 3];
    let mut rest = Some(word);
    for kind in 0.. {
        let Some(text) = rest else { break };
        let Some(what) = KINDS.get(kind) else {
            return Err(format!("too many slashes in `{}`", shown(word)));
        };
        // Most numbers have a few digits and no sign: these are read in one go.
        let (plain, digits) = leading_number(text.as_bytes());
        let (part, after) = match text.as_bytes().get(digits) {
            None => (text, None),
            Some(b'/') => (&text[..digits], Some(&text[digits + 1..])),
            Some(_) => match text.split_once('/') {
                Some((part, after)) => (part, Some(after)),
                None => (text, None),
            },
        };
        rest = after;
        if part.is_empty() && kind > 0 {
            continue;
        }
        let number = match part.len() == digits && digits > 0 {
            true => plain,
            false => part.parse().map_err(|_| {
                format!(
                    "expected the number of a {what}, found `{}` in `{}`",
                    shown(part),
                    shown(word)
                )
            })?,
        };
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

/// Returns the number that the first digits of a text make, of which nine are read, and how many these are.
fn leading_number(text: &[u8]) -> (i64, usize) {
    let (mut number, mut digits) = (0, 0);
    for byte in text.iter().take(9) {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        number = 10 * number + i64::from(digit);
        digits += 1;
    }
    (number, digits)
}
