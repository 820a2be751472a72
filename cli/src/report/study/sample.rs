//! A small study for tests: one unbiased and one biased variant.

use super::Findings;
use etendue_lab::bench::report::Machine;
use etendue_lab::study::clock::Seconds;
use etendue_lab::study::fit::TimeLaw;
use etendue_lab::study::gram::Gram;
use etendue_lab::study::reference::ReferenceNoise;
use etendue_lab::study::report::{
    LevelReport, ReferenceReport, RunReport, StudyReport, VariantStudy,
};
use etendue_lab::study::summary::summaries;
use etendue_lab::study::variant::VariantReport;

fn level(spp: u64, bias: f64) -> LevelReport {
    let mut level = LevelReport {
        spp,
        runs: Vec::new(),
        gram: Gram::default(),
    };
    for seed in 0..6_u64 {
        // A small deterministic deviation, so that the tests do not depend on chance.
        let noise = 1e-4 * (seed as f64 - 2.5) / spp as f64;
        let rel_mse = 0.01 / spp as f64 + bias + noise;
        let product = |k: u64| bias + 1e-7 * ((seed + k) % 3) as f64 - 1e-7;
        let products: Vec<f64> = (0..seed).map(product).collect();
        level.gram.push(products.clone(), &products, rel_mse);
        let wall = 0.01 + 0.001 * spp as f64;
        level.runs.push(RunReport {
            seed,
            order: seed as usize,
            seconds: Seconds {
                wall,
                cpu: 2.0 * wall,
            },
            repeated: false,
            rel_mse,
            trimmed: 0.9 * rel_mse,
            luminance: 0.5,
            rejected: 0,
        });
    }
    level
}

fn variant(integrator: &'static str, bias: f64) -> VariantStudy {
    VariantStudy {
        variant: VariantReport {
            name: format!("{integrator}, sobol"),
            integrator,
            sampler: "sobol",
            backend: "obvhs-bvh2",
            precision: "robust",
            light_paths: "off",
            reuse: "off",
            kernel: None,
            max_bounces: None,
            bias: Vec::new(),
        },
        warm_up: TimeLaw {
            start: 0.01,
            sample: 0.001,
        },
        own_size: None,
        build: 0.1,
        levels: [1, 2, 4, 8].map(|spp| level(spp, bias)).to_vec(),
        repeated: 1,
        disturbed: 0,
        error_record: None,
        bars: None,
        tile_p_values: vec![0.1, 0.5, 0.9],
        paths: None,
        bounces: Vec::new(),
    }
}

/// Returns the study.
pub fn report() -> StudyReport {
    StudyReport {
        version: "1.2.3",
        scene: "box.toml".to_owned(),
        full_size: (16, 16),
        size: (16, 16),
        threads: 2,
        budget: 10.0,
        seconds: 9.0,
        complete: true,
        reference: Some(ReferenceReport {
            integrator: "path",
            sampler: "sobol",
            spp: 256,
            seconds: [Seconds::default(); 2],
            seeds: [1, 2],
            luminances: [0.499, 0.501],
            luminance_error: 1e-3,
            noise: ReferenceNoise {
                rel_mse: 1e-5,
                product_deviation: 1e-7,
            },
        }),
        variants: vec![variant("path", 0.0), variant("bsdf", 0.02)],
        ..StudyReport::default()
    }
}

/// Returns the findings of a study.
pub fn findings(report: &StudyReport) -> Findings<'_> {
    static MACHINE: Machine = Machine {
        processor: String::new(),
        processors: 2,
        system: String::new(),
        embree: String::new(),
    };
    Findings {
        report,
        summaries: summaries(report),
        machine: &MACHINE,
        command: "etendue study box.toml",
        recommendation: None,
    }
}
