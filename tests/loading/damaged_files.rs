//! Fuzz tests of randomly damaged scenes, models and material libraries: errors are allowed, panics are not.

use crate::common::scene_folder::{SMALL, SceneFolder};
use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop_oneof, proptest};

/// A random change of a file.
#[derive(Debug, Clone)]
enum Damage {
    Replace(u8),
    Insert(&'static str),
    Remove(usize),
    Repeat(usize),
}

fn damage() -> impl Strategy<Value = Vec<(usize, Damage)>> {
    const WORDS: &[&str] = &[
        "-", "0", "9", "e999", "nan", "\n", "\0", "\"", "[", "{", "/", " ", "\\", "\u{feff}",
    ];
    let one = prop_oneof![
        any::<u8>().prop_map(Damage::Replace),
        proptest::sample::select(WORDS).prop_map(Damage::Insert),
        (1..20_usize).prop_map(Damage::Remove),
        (1..40_usize).prop_map(Damage::Repeat),
        Just(Damage::Insert("1")),
    ];
    proptest::collection::vec((any::<usize>(), one), 1..6)
}

fn damaged(text: &str, damages: &[(usize, Damage)]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (place, damage) in damages {
        let start = place % (bytes.len() + 1);
        let end = bytes.len();
        let part = |length: usize| start..(start + length).min(end);
        match damage {
            Damage::Replace(byte) => bytes[part(1)].fill(*byte),
            Damage::Insert(word) => drop(bytes.splice(start..start, word.bytes())),
            Damage::Remove(length) => drop(bytes.drain(part(*length))),
            Damage::Repeat(length) => {
                let again = bytes[part(*length)].to_vec();
                drop(bytes.splice(start..start, again));
            }
        }
    }
    bytes
}

/// Loads a scene that may be damaged, and prepares it if it is valid: errors are allowed, panics are not.
fn survives(files: [(&'static str, Vec<u8>); 2], scene: &str) {
    let folder = SceneFolder::new(files);
    if let Ok(description) = load(&folder.path(scene)) {
        let options = AccelOptions {
            backend: Backend::ALL[0],
            precision: Precision::Robust,
            quality: None,
            threads: 1,
        };
        let _ = prepare(&description, options);
    }
}

const MODEL: &str = "mtllib a.mtl\no one\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nvt 0 0\nvt 1 1\nvn 0 0 1\n\
                     usemtl red\nf 1/1/1 2/2/1 3/1/1\nusemtl glass\nf -1//1 -2//1 -3//1\nf 1 2 4 3\nl 1 2\n";
const LIBRARY: &str =
    "newmtl red\nKd 0.5 0 0\nPr 0.5\nPm 0\nKe 1 1 1\nnewmtl glass\nTf 1 1 1\nNi 1.5\nd 1\nNs 20\n";

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn loading_randomly_damaged_files_does_not_panic(damages in damage(), which in 0..3_u8) {
        let hurt = |this: u8, text: &str| if this == which { damaged(text, &damages) } else { text.into() };
        if which == 0 {
            survives([("a.toml", hurt(0, SMALL)), ("a.mtl", Vec::new())], "a.toml");
        } else {
            survives([("a.obj", hurt(1, MODEL)), ("a.mtl", hurt(2, LIBRARY))], "a.obj");
        }
    }
}
