//! Lights to begin with: a press replaces suns, area lights and surroundings, one step of the history. The background
//! stays.

use egui::{Button, Ui};
use renderer_core::design::{AreaLight, Colour, Design, Environment, EnvironmentKind, Light, Sun};

/// A light by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightPreset {
    /// A high hard sun under a blue sky.
    Noon,
    /// Soft light from one side, as in a room.
    Window,
    /// Two large soft lights, as for a catalogue.
    Softbox,
    /// A low warm sun.
    Evening,
}

impl LightPreset {
    /// All of them, in the order of the buttons.
    pub const ALL: [Self; 4] = [Self::Noon, Self::Window, Self::Softbox, Self::Evening];

    /// What the button says.
    pub fn name(self) -> &'static str {
        match self {
            Self::Noon => "Noon",
            Self::Window => "Window",
            Self::Softbox => "Studio softbox",
            Self::Evening => "Evening",
        }
    }

    fn what(self) -> &'static str {
        match self {
            Self::Noon => "A high, hard sun under a blue sky: sharp shadows between the loops.",
            Self::Window => "A tall window on the left and a little cool light from all around.",
            Self::Softbox => {
                "A large softbox and a weaker one opposite, as for a catalogue: even, hardly any shadow."
            }
            Self::Evening => "A low, warm sun from the side: every loop throws a long shadow.",
        }
    }

    /// The light of `design` with these suns, area lights and surroundings. Area lights are as large and as far away
    /// for any cloth as that is large.
    pub fn applied_to(self, design: &Design) -> Light {
        let sheet = &design.sheet;
        let sides = [
            f64::from(sheet.warps) * sheet.pitch_x(),
            f64::from(sheet.wefts) * sheet.pitch_y(),
        ];
        let cloth_mm = sides[0].max(sides[1]);
        let sky = |radiance, zenith, horizon, ground| Environment {
            kind: EnvironmentKind::Gradient,
            radiance,
            zenith: Colour(zenith),
            horizon: Colour(horizon),
            ground: Colour(ground),
            ..Environment::default()
        };
        let sun = |[azimuth, elevation, irradiance, angular_diameter]: [f64; 4], colour| Sun {
            azimuth,
            elevation,
            irradiance,
            angular_diameter,
            colour: Colour(colour),
        };
        // Azimuth and elevation, irradiance; distance, width and height in cloths.
        let area = |[azimuth, elevation, irradiance]: [f64; 3], in_cloths: [f64; 3], colour| {
            let [distance, width, height] =
                in_cloths.map(|share| (0.1 * share * cloth_mm).ceil() * 10.0);
            AreaLight {
                azimuth,
                elevation,
                distance: distance.max(design.nearest_area_mm(azimuth, elevation)),
                width,
                height,
                irradiance,
                colour: Colour(colour),
            }
        };
        let (suns, areas, environment) = match self {
            Self::Noon => (
                vec![sun([110.0, 68.0, 3.2, 0.5], [255, 246, 230])],
                Vec::new(),
                sky(0.35, [176, 206, 255], [240, 245, 255], [120, 112, 100]),
            ),
            Self::Window => (
                Vec::new(),
                vec![area([180.0, 28.0, 3.8], [3.0, 1.6, 3.2], [255, 252, 247])],
                sky(0.36, [226, 236, 255], [242, 246, 255], [160, 154, 144]),
            ),
            Self::Softbox => (
                Vec::new(),
                vec![
                    area([135.0, 55.0, 2.1], [2.5, 2.4, 2.4], [255, 255, 255]),
                    area([-35.0, 40.0, 0.8], [3.0, 2.4, 3.2], [255, 255, 255]),
                ],
                sky(0.38, [255, 255, 255], [255, 255, 255], [200, 200, 200]),
            ),
            Self::Evening => (
                vec![sun([200.0, 15.0, 4.5, 2.0], [255, 196, 134])],
                Vec::new(),
                sky(0.6, [110, 140, 210], [255, 214, 170], [90, 84, 80]),
            ),
        };
        Light {
            sun: suns,
            area: areas,
            environment,
            background: design.light.background,
        }
    }
}

/// A line of buttons; the light whose button was pressed.
pub fn show(ui: &mut Ui, design: &mut Design) -> Option<LightPreset> {
    let mut pressed = None;
    ui.horizontal_wrapped(|ui| {
        for ready in LightPreset::ALL {
            let is_on = ready.applied_to(design) == design.light;
            let button = ui.add(Button::new(ready.name()).selected(is_on));
            if button.on_hover_text(ready.what()).clicked() {
                pressed = Some(ready);
            }
        }
    });
    if let Some(ready) = pressed {
        design.light = ready.applied_to(design);
    }
    pressed
}
