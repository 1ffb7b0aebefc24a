//! What is measured: the settings, each a curve of the plot, and which truth they are held to.
//!
//! Methods differ by their bias in the light that scatters once (MODEL.md §9): every preset is measured for it. Where a
//! preset's own pictures have more scatterings, these are a second target, with a truth of their own.

use renderer_core::design::{Method, Quality, Sampler};
use renderer_core::render::Optimisation;

use towel_designer::designer::CACHED_SHADOWS;

/// The method that makes the truth. It has no step and no bias, nothing but noise, and that noise falls some three
/// times as fast as that of `exact`, which differs from it by its step alone: the table of costs shows by how much.
pub const TRUTH: Method = Method::Tracked;

/// Everything that a picture's maker can choose but the number of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    /// How a ray gathers light.
    pub method: Method,
    /// Where random numbers come from.
    pub sampler: Sampler,
    /// Rays towards lights are followed.
    pub shadows: bool,
    /// Most scatterings of a path.
    pub bounces: u32,
    /// Scatterings after which the light of further ones is estimated, not traced; 0 traces all.
    pub traced_bounces: u32,
    /// First samples whose shadows neighbouring points share.
    pub cached_shadows: u32,
    /// Work that is done though it cannot be seen, to show what leaving it out is worth: no choice of users.
    pub without: Option<Optimisation>,
    /// Each picture is drawn anew up to an error target, where others are drawn on and on.
    pub to_error: bool,
}

impl Setting {
    /// Its name in tables: "single, random, no shadows".
    pub fn name(&self, target: &Target) -> String {
        let sampler = match self.sampler {
            Sampler::Owen => "Owen",
            Sampler::Random => "random",
        };
        let shadows = if self.shadows { "" } else { ", no shadows" };
        let bounces = match self.bounces {
            bounces if bounces == target.bounces => String::new(),
            bounces => format!(", bounces = {bounces}"),
        };
        let traced = match self.traced_bounces {
            0 => String::new(),
            traced => format!(", traced_bounces = {traced}"),
        };
        let cached = match self.cached_shadows {
            0 => String::new(),
            cached => format!(", cached_shadows = {cached}"),
        };
        let without = match self.without {
            None => String::new(),
            Some(optimisation) => format!(", without {optimisation}"),
        };
        let to_error = if self.to_error {
            ", up to error targets"
        } else {
            ""
        };
        format!(
            "{}, {sampler}{shadows}{bounces}{traced}{cached}{to_error}{without}",
            self.method.name()
        )
    }

    /// Whether its rows are compared with those of others: not where work is done to measure what leaving it out is
    /// worth, nor where pixels differ in their samples.
    pub fn is_choice(&self) -> bool {
        self.without.is_none() && !self.to_error
    }

    /// Whether all light of `target` is traced.
    pub fn is_whole(&self, target: &Target) -> bool {
        self.bounces == target.bounces && self.traced_bounces == 0
    }

    /// How much of the time this setting gets: most for those that a user would choose.
    fn weight(&self) -> f64 {
        match (self.sampler, self.shadows) {
            // A yardstick, and no choice.
            _ if self.method == Method::SixFace => 0.5,
            // No error is known before there are sixteen samples.
            _ if self.to_error => 8.0,
            _ if self.without.is_some() => 1.0,
            _ if self.cached_shadows > 0 => 2.0,
            (Sampler::Owen, true) => 4.0,
            (Sampler::Random, true) => 1.0,
            // The error soon stops falling.
            (_, false) => 0.5,
        }
    }
}

/// The part of `left` that the first of `settings` may use now, if the others are to have theirs.
pub fn share(settings: &[Setting], left: f64) -> f64 {
    let weights: f64 = settings.iter().map(Setting::weight).sum();
    settings
        .first()
        .map_or(0.0, |first| left * first.weight() / weights)
}

/// A truth, and what is held to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Most scatterings of a path in the truth.
    pub bounces: u32,
    /// What is measured; those that users would choose first, so that a small budget reaches them.
    pub settings: Vec<Setting>,
    /// Share of the preset's budget.
    pub share: f64,
}

impl Target {
    /// Its name in titles.
    pub fn name(&self) -> String {
        match self.bounces {
            1 => "light that scatters once".into(),
            bounces => format!("light that scatters up to {bounces} times"),
        }
    }
}

/// What is measured of a preset with `methods`, those that the backend has. `optimisations` are those of the preset's
/// own method.
pub fn targets(
    quality: &Quality,
    methods: &[Method],
    optimisations: &[Optimisation],
) -> Vec<Target> {
    let mut direct = Vec::new();
    for (sampler, shadows) in [
        (Sampler::Owen, true),
        (Sampler::Random, true),
        (Sampler::Owen, false),
        (Sampler::Random, false),
    ] {
        direct.extend(methods.iter().map(|&method| Setting {
            method,
            sampler,
            shadows,
            bounces: 1,
            traced_bounces: 0,
            cached_shadows: 0,
            without: None,
            to_error: false,
        }));
    }
    let whole = direct
        .iter()
        .find(|setting| setting.method == quality.method);
    if let Some(&whole) = whole {
        direct.push(Setting {
            cached_shadows: CACHED_SHADOWS,
            ..whole
        });
        for &optimisation in optimisations {
            // Tiles can end before the picture only where there is an error to end at: with it and without, for want of
            // any other to compare with.
            let to_error = optimisation == Optimisation::ConvergedTiles;
            direct.extend(to_error.then_some(Setting { to_error, ..whole }));
            direct.push(Setting {
                without: Some(optimisation),
                to_error,
                ..whole
            });
        }
    }
    let has_more = quality.bounces > 1;
    let mut targets = vec![Target {
        bounces: 1,
        settings: direct,
        share: if has_more { 0.6 } else { 1.0 },
    }];
    if has_more {
        targets.push(Target {
            bounces: quality.bounces,
            settings: all_of_the_light(quality.bounces),
            share: 0.4,
        });
    }
    targets
}

/// Ways to the light of many scatterings: paths; the live view's estimate of all but the first; and nothing but the
/// first.
fn all_of_the_light(bounces: u32) -> Vec<Setting> {
    let setting = |method, sampler, bounces, traced_bounces| Setting {
        method,
        sampler,
        shadows: true,
        bounces,
        traced_bounces,
        cached_shadows: 0,
        without: None,
        to_error: false,
    };
    vec![
        setting(Method::Tracked, Sampler::Owen, bounces, 0),
        setting(Method::Tracked, Sampler::Owen, bounces, 1),
        // As the live view has it.
        Setting {
            cached_shadows: CACHED_SHADOWS,
            ..setting(Method::Tracked, Sampler::Owen, bounces, 1)
        },
        setting(Method::Single, Sampler::Owen, bounces, 0),
        setting(Method::Single, Sampler::Owen, bounces, 1),
        setting(Method::Single, Sampler::Owen, 1, 0),
        setting(Method::Tracked, Sampler::Random, bounces, 0),
    ]
}
