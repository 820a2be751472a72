//! Refractive indices by the names of Mitsuba.
//!
//! Measure: relative to vacuum; metals per channel of linear Rec. 709.
//! Range: the names listed; others are unknown.
//! Source: metals: spectra of Palik's "Handbook of Optical Constants of Solids" and of the SOPRA data base, integrated
//! to Rec. 709; the numbers are those that Mitsuba 3.9.1 reports for its presets (`mitsuba.traverse`). Media: sodium D
//! line, Hecht, "Optics". Tested in `tests/loading/mitsuba.rs`.

use crate::math::rgb::Rgb;

/// Name, eta and k.
pub const METALS: &[(&str, [f32; 3], [f32; 3])] = &[
    ("Ag", [0.1553, 0.1167, 0.1384], [4.8284, 3.1222, 2.1469]),
    ("Al", [1.6575, 0.8804, 0.5212], [9.2238, 6.2695, 4.8369]),
    ("Au", [0.1430, 0.3753, 1.4420], [3.9830, 2.3856, 1.6034]),
    ("Be", [4.1850, 3.1850, 2.7841], [3.8355, 3.0101, 2.8690]),
    ("Cr", [4.3697, 2.9165, 1.6549], [5.2065, 4.2313, 3.7547]),
    ("Cu", [0.2010, 0.9237, 1.1022], [3.9133, 2.4530, 2.1421]),
    ("Hg", [2.3989, 1.4401, 0.9096], [6.3276, 4.3719, 3.4218]),
    ("Ir", [3.0863, 2.0822, 1.6179], [5.5922, 4.0671, 3.2673]),
    ("K", [0.0640, 0.0464, 0.0382], [2.1042, 1.3489, 0.9131]),
    ("Mo", [4.4840, 3.5251, 2.7763], [4.1114, 3.4208, 3.1506]),
    (
        "Ni_palik",
        [2.3673, 1.6634, 1.4671],
        [4.4988, 3.0502, 2.3454],
    ),
    ("TiN", [1.6484, 1.1505, 1.3798], [3.3683, 1.9435, 1.1021]),
    ("W", [4.3708, 3.3002, 2.9984], [3.5006, 2.6049, 2.2732]),
];

/// Name and index.
pub const MEDIA: &[(&str, f64)] = &[
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.3330),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.520_45),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.470),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.5750),
    ("diamond", 2.419),
];

/// Returns eta and k of a metal.
pub fn metal(name: &str) -> Option<(Rgb, Rgb)> {
    let found = METALS.iter().find(|(known, _, _)| *known == name);
    found.map(|&(_, eta, k)| (Rgb::from(eta), Rgb::from(k)))
}

/// Returns the index of a medium.
pub fn medium(name: &str) -> Option<f64> {
    let found = MEDIA.iter().find(|(known, _)| *known == name);
    found.map(|&(_, index)| index)
}
