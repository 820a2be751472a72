//! Renders with the instruction sets of older processors: Embree rounds differently, but images agree.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::command;
use etendue::internals::image::{ColourSpace, Image};

/// Surfaces with alpha are found again after each that a ray has passed, at a distance that is rounded anew.
const ALPHA: &str = "
[[material]]
name = \"grid\"
type = \"diffuse\"
reflectance = 0.4
alpha = 0.5

[[shape]]
type = \"rectangle\"
material = \"grid\"
corner = [-2, 0, 1]
edge_u = [4, 0, 0]
edge_v = [0, 3, 0.5]
";

#[test]
fn images_with_other_instruction_sets_agree() {
    let folder = SceneFolder::new([("alpha.toml", format!("{SMALL}{ALPHA}"))]);
    let mean = |name: &str, isa: Option<&str>, precision: &str| {
        let flags = format!("render alpha.toml -q --spp 64 --precision {precision} -o {name}.pfm");
        let mut command = command(&folder, &flags);
        if let Some(isa) = isa {
            command.env("ETENDUE_EMBREE", format!("isa={isa}"));
        }
        let output = command.output().expect("the command starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {message}");
        let image = Image::read(&folder.path(&format!("{name}.pfm")), ColourSpace::Linear);
        image.expect("an image").mean()
    };
    for precision in ["robust", "fast"] {
        let own = mean("own", None, precision);
        for isa in ["sse2", "sse4.2"] {
            let other = mean(isa, Some(isa), precision);
            // The paths are the same but for those that meet an edge.
            let differs = own
                .iter()
                .zip(other)
                .any(|(a, b)| (a / b - 1.0).abs() > 1e-2);
            assert!(!differs, "{precision}, {isa}: {own:?} {other:?}");
        }
    }
}
