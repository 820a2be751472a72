//! The spectra that pbrt knows by name: refractive indices of metals and glasses, and the CIE's standard illuminants.
//!
//! Measure: indices at 630, 532 and 465 nm; glass has the index of the d line, 587.6 nm, in every channel.
//! Range: the names of pbrt-v4 except those of its cameras' sensors.
//! Source: `bsdf::conductor::PRESETS` for copper, gold, silver and aluminium; refractiveindex.info (public domain) for
//! brass, magnesia and titania; Schott's data sheets for glass; CIE 015 for chromaticities, ACES for its D60. Tested in
//! `load/spectrum.rs`.

/// Refractive indices: the real part, or the imaginary part for names that end in `-k`.
pub const INDICES: &[(&str, [f32; 3])] = &[
    ("metal-Ag-eta", [0.06, 0.05, 0.05]),
    ("metal-Ag-k", [4.25, 3.43, 2.80]),
    ("metal-Al-eta", [1.36, 0.92, 0.69]),
    ("metal-Al-k", [7.38, 6.31, 5.57]),
    ("metal-Au-eta", [0.19, 0.54, 1.33]),
    ("metal-Au-k", [3.40, 2.23, 1.87]),
    ("metal-Cu-eta", [0.28, 1.12, 1.25]),
    ("metal-Cu-k", [3.37, 2.60, 2.46]),
    ("metal-CuZn-eta", [0.445, 0.568, 0.947]),
    ("metal-CuZn-k", [3.52, 2.59, 1.92]),
    ("metal-MgO-eta", [1.735, 1.742, 1.750]),
    ("metal-MgO-k", [0.0, 0.0, 0.0]),
    ("metal-TiO2-eta", [2.875, 2.969, 3.118]),
    ("metal-TiO2-k", [0.0, 0.0, 0.0]),
    ("glass-BK7", [1.5168; 3]),
    ("glass-BAF10", [1.6700; 3]),
    ("glass-FK51A", [1.4866; 3]),
    ("glass-LASF9", [1.8503; 3]),
    ("glass-F5", [1.6727; 3]),
    ("glass-F10", [1.7283; 3]),
    ("glass-F11", [1.7847; 3]),
];

/// Chromaticities x, y of illuminants.
pub const ILLUMINANTS: &[(&str, [f64; 2])] = &[
    ("stdillum-A", [0.44758, 0.40745]),
    ("stdillum-D50", [0.34567, 0.35850]),
    ("stdillum-D65", [0.31272, 0.32903]),
    ("stdillum-F1", [0.3131, 0.3371]),
    ("stdillum-F2", [0.3721, 0.3751]),
    ("stdillum-F3", [0.4091, 0.3941]),
    ("stdillum-F4", [0.4402, 0.4031]),
    ("stdillum-F5", [0.3138, 0.3452]),
    ("stdillum-F6", [0.3779, 0.3882]),
    ("stdillum-F7", [0.3129, 0.3292]),
    ("stdillum-F8", [0.3458, 0.3586]),
    ("stdillum-F9", [0.3741, 0.3727]),
    ("stdillum-F10", [0.3458, 0.3588]),
    ("stdillum-F11", [0.3805, 0.3769]),
    ("stdillum-F12", [0.4370, 0.4042]),
    ("illum-acesD60", [0.32168, 0.33767]),
];
