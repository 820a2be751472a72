//! Tests of bodies that come in pieces.

use super::super::fingerprint::Fingerprint;
use super::*;
use crate::film::Window;
use crate::film::batches::BATCHES;
use serde_json::Map;

/// The header and the film of an image with all kinds of sums, no two of which are equal.
fn example() -> (StateHeader, Film) {
    let identity = Fingerprint {
        program: String::new(),
        scene: String::new(),
        scene_parts: Default::default(),
        settings: Map::new(),
    };
    let window = Window::whole((9, 7));
    let header = StateHeader {
        tile_size: 4,
        border_size: 1,
        done: vec![[0, 4]],
        splat_samples: Some([1; BATCHES as usize]),
        ..StateHeader::new(identity, String::new(), window)
    };
    let mut film = header.empty_film().expect("it is small");
    let (tiles, splats) = film.parts_mut();
    let mut count = 0;
    let mut next = || {
        count += 1;
        (count % 24, count as f64)
    };
    for tile in tiles {
        tile.samples = 4;
        let splatted = tile.splatted.as_mut().map(Splatted::sums_mut);
        for sums in splatted.into_iter().flatten() {
            let (double, value) = next();
            sums.add_double(double, value);
        }
    }
    for row in splats.expect("it has splats").rows_mut() {
        for sums in row {
            let (double, value) = next();
            sums.add_double(double, value);
        }
    }
    (header, film)
}

fn written(film: &Film) -> Vec<u8> {
    let mut bytes = vec![];
    write(film, &[], None, &mut bytes).expect("memory can be written to");
    bytes
}

/// Adds a body that comes in pieces of this length to an empty film.
fn added(header: &StateHeader, bytes: &[u8], length: usize, piece: usize) -> Result<Film> {
    let mut film = header.empty_film()?;
    let mut pieces = bytes.chunks(piece).map(<[u8]>::to_vec);
    let mut next_piece = || Ok(pieces.next());
    let mut body = Body::in_pieces(&mut next_piece, length as u64);
    body.least = 1;
    add_to(header, body, &mut film)?;
    Ok(film)
}

#[test]
fn length_of_pieces_changes_no_sum() {
    let (header, film) = example();
    let bytes = written(&film);
    let mut whole = header.empty_film().expect("it is small");
    add_to(&header, Body::of(&bytes), &mut whole).expect("it is whole");
    assert!(written(&whole) == bytes);
    for piece in [1, 7, 64, 1000, bytes.len()] {
        let added = added(&header, &bytes, bytes.len(), piece).expect("it is whole");
        assert!(written(&added) == bytes, "pieces of {piece} bytes");
    }
}

#[test]
fn pieces_that_end_early_or_go_on_are_rejected() {
    let (header, film) = example();
    let mut bytes = written(&film);
    let length = bytes.len();
    for end in [0, 1, 100, length / 2, length - 1] {
        assert!(
            added(&header, &bytes[..end], length, 64).is_err(),
            "{end} bytes"
        );
        assert!(
            added(&header, &bytes[..end], end, 64).is_err(),
            "{end} bytes"
        );
    }
    bytes.push(0);
    let error = added(&header, &bytes, length + 1, 64).map(drop);
    let message = error.expect_err("a byte follows").to_string();
    assert!(message.contains("1 bytes follow"), "{message}");
}
