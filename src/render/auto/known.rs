//! Choices that are known from a render of the same scene with the same settings, in place of pilots that would choose the
//! same: those of its shards, for one.
//!
//! Measure: none.
//! Range: any settings, and the map of settings of any state; what the settings name themselves stays. Whether the state is of
//! the same render is for the caller to compare afterwards.
//! Source: none needed. Tested in `cli/tests/command/choices.rs`.

use super::super::settings::{LightPathRule, PathReuseRule, RenderSettings};
use crate::integrator::kind::IntegratorKind;
use serde::Serialize;
use serde_json::{Map, Value};

/// Replaces what settings leave to pilots by the choices in the map of settings of a state.
pub fn with_known_choices(settings: &RenderSettings, known: &Map<String, Value>) -> RenderSettings {
    let mut settings = settings.clone();
    let name = |key: &str| known.get(key).and_then(Value::as_str);
    if settings.integrator == IntegratorKind::Auto {
        let named = |kind: &&IntegratorKind| name("integrator") == Some(kind.name());
        let kind = IntegratorKind::ALL.iter().find(named);
        settings.integrator = kind.copied().unwrap_or(settings.integrator);
    }
    if settings.light_paths == LightPathRule::Auto {
        let kept = kept(known, "light_paths", LightPathRule::ALL);
        settings.light_paths = kept.unwrap_or_default();
    }
    if settings.reuse == PathReuseRule::Auto {
        let kept = kept(known, "reuse", PathReuseRule::ALL);
        settings.reuse = kept.unwrap_or_default();
    }
    if settings.integrator == IntegratorKind::Path && settings.has_window_pilot {
        let kept = name("roulette").and_then(|name| name.parse().ok());
        settings.roulette = settings.roulette.or(kept);
    }
    settings
}

/// The one of these rules that a map has under a key, in the form in which it is serialised.
fn kept<T: Serialize + Copy>(known: &Map<String, Value>, key: &str, all: &[T]) -> Option<T> {
    let kept = known.get(key)?;
    let is_kept = |rule: &&T| serde_json::to_value(rule).is_ok_and(|rule| rule == *kept);
    all.iter().find(is_kept).copied()
}
