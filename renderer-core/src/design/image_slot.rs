//! The images of a design, in one table: where a design names each, what its pixels are, and what depends on its being
//! there. Whatever reads, writes, packs or copies images goes through [`ImageSlot`], so that one more is one more row.

use std::borrow::Cow;

use super::{
    ChartImage, ChartObject, Design, EnvironmentImage, EnvironmentKind, FormKind, HeightImage,
};

/// Pixels of any image of a design. Copies share them.
#[derive(Debug, Clone, PartialEq)]
pub enum ImagePixels {
    /// Colours as displayed, of 8 bits.
    Colours(ChartImage),
    /// Light from all around.
    Light(EnvironmentImage),
    /// Grey values of 16 bits.
    Heights(HeightImage),
}

/// Which kind of [`ImagePixels`] an image has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelKind {
    /// Colours as displayed, of 8 bits.
    Colours,
    /// Light from all around.
    Light,
    /// Grey values of 16 bits.
    Heights,
}

/// Declares the images: name and kind of pixels, the section that has `image` and `pixels`, and the choice that shows
/// the image with the one that does without, where there are such.
macro_rules! image_slots {
    ($(
        $(#[doc = $doc:literal])+
        $slot:ident: $kind:ident in $first:ident $(. $next:ident)*
            $(, shown where $place:ident $(. $rest:ident)* = $choice:ident::$with:ident, else $without:ident)?;
    )+) => {
        /// An image that a design may have.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum ImageSlot {
            $( $(#[doc = $doc])+ $slot, )+
            /// The picture that this object of the chart is, counted from 0.
            Object(u16),
        }

        impl ImageSlot {
            /// The images that every design has a place for, the commonest first.
            pub const ALL: [Self; [$(Self::$slot),+].len()] = [$(Self::$slot),+];

            /// The images that a design has a place for: [`Self::ALL`] and the pictures on its chart.
            pub fn of(design: &Design) -> impl Iterator<Item = Self> + use<> {
                let objects = design.chart.object.len().min(ChartObject::MAX) as u16;
                Self::ALL.into_iter().chain((0..objects).map(Self::Object))
            }

            /// The field that names its file, as in presets.
            pub fn field(self) -> Cow<'static, str> {
                match self {
                    $(Self::$slot => {
                        concat!(stringify!($first), ".", $(stringify!($next), ".",)* "image").into()
                    })+
                    Self::Object(index) => format!("chart.object[{index}].image").into(),
                }
            }

            /// What its pixels are.
            pub fn kind(self) -> PixelKind {
                match self {
                    $(Self::$slot => PixelKind::$kind,)+
                    Self::Object(_) => PixelKind::Colours,
                }
            }

            /// The path of its file, or its name where the design carries it.
            pub fn path(self, design: &Design) -> Option<&str> {
                match self {
                    $(Self::$slot => design.$first$(.$next)*.image.as_deref(),)+
                    Self::Object(index) => object(design, index)?.image.as_deref(),
                }
            }

            /// Names its file, or says that it is in none; a picture of an object that is not there has no place.
            pub fn set_path(self, design: &mut Design, path: Option<String>) {
                match self {
                    $(Self::$slot => design.$first$(.$next)*.image = path,)+
                    Self::Object(index) => {
                        if let Some(object) = object_mut(design, index) {
                            object.image = path;
                        }
                    }
                }
            }

            /// Its pixels.
            pub fn pixels(self, design: &Design) -> Option<ImagePixels> {
                match self {
                    $(Self::$slot => design.$first$(.$next)*.pixels.clone().map(ImagePixels::$kind),)+
                    Self::Object(index) => {
                        object(design, index)?.pixels.clone().map(ImagePixels::Colours)
                    }
                }
            }

            /// Whether a design has it.
            pub fn has_pixels(self, design: &Design) -> bool {
                match self {
                    $(Self::$slot => design.$first$(.$next)*.pixels.is_some(),)+
                    Self::Object(index) => {
                        object(design, index).is_some_and(|object| object.pixels.is_some())
                    }
                }
            }

            /// Gives a design its pixels; those of another kind than [`Self::kind`] count as none.
            pub fn set_pixels(self, design: &mut Design, pixels: Option<ImagePixels>) {
                match (self, pixels) {
                    $(
                        (Self::$slot, Some(ImagePixels::$kind(pixels))) => {
                            design.$first$(.$next)*.pixels = Some(pixels);
                        }
                        (Self::$slot, _) => design.$first$(.$next)*.pixels = None,
                    )+
                    (Self::Object(index), pixels) => {
                        if let Some(object) = object_mut(design, index) {
                            object.pixels = match pixels {
                                Some(ImagePixels::Colours(pixels)) => Some(pixels),
                                _ => None,
                            };
                        }
                    }
                }
            }

            /// Lets the design show the image it was given.
            pub fn show(self, design: &mut Design) {
                match self {
                    $(Self::$slot => { $( design.$place$(.$rest)* = $choice::$with; )? })+
                    Self::Object(_) => {}
                }
            }

            /// Leaves the image out, and where the design shows it, what needs no image takes its place.
            pub fn leave_out(self, design: &mut Design) {
                self.set_path(design, None);
                self.set_pixels(design, None);
                match self {
                    $(Self::$slot => { $(
                        let kind = &mut design.$place$(.$rest)*;
                        if *kind == $choice::$with {
                            *kind = $choice::$without;
                        }
                    )? })+
                    Self::Object(_) => {}
                }
            }
        }
    };
}

fn object(design: &Design, index: u16) -> Option<&ChartObject> {
    design.chart.object.get(usize::from(index))
}

fn object_mut(design: &mut Design, index: u16) -> Option<&mut ChartObject> {
    design.chart.object.get_mut(usize::from(index))
}

image_slots! {
    /// The colour of each loop.
    Chart: Colours in chart;
    /// Which way the pile is brushed.
    Nap: Colours in nap;
    /// The light from all around.
    Environment: Light in light.environment,
        shown where light.environment.kind = EnvironmentKind::Image, else Constant;
    /// How high the cloth lies.
    Height: Heights in form, shown where form.kind = FormKind::Height, else Flat;
}
