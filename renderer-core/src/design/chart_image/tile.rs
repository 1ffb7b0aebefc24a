//! One tile of a chart: 128 × 128 pixels. Up to 256 colours are kept as a list of colours and a number a pixel, so that
//! a tile of a chart of yarns takes a quarter of the memory, and another colour for a yarn costs a list, not the
//! pixels.

use std::sync::{Arc, OnceLock};

/// Side of a tile in pixels.
pub const TILE: usize = 128;

/// Pixels of a tile.
const PIXELS: usize = TILE * TILE;

/// Most colours that numbers of one byte can tell apart.
const MOST_COLOURS: usize = 256;

/// Pixels of one tile, row by row, shared between copies. Parts of edge tiles beyond the image mean nothing.
#[derive(Clone)]
pub struct Tile(Pixels);

#[derive(Clone)]
enum Pixels {
    /// A colour for each pixel.
    Each(Arc<[[u8; 4]]>),
    /// The number of a colour for each pixel.
    Numbered {
        colours: Arc<[[u8; 4]]>,
        numbers: Arc<[u8]>,
    },
}

/// The numbers of all tiles of one colour.
fn zeros() -> Arc<[u8]> {
    static ZEROS: OnceLock<Arc<[u8]>> = OnceLock::new();
    Arc::clone(ZEROS.get_or_init(|| Arc::from([0; PIXELS])))
}

impl Tile {
    /// A tile of one colour.
    pub(super) fn filled(colour: [u8; 4]) -> Self {
        Self(Pixels::Numbered {
            colours: Arc::from([colour]),
            numbers: zeros(),
        })
    }

    /// A tile of these pixels, [`TILE`] × [`TILE`] of them.
    pub(super) fn new(pixels: &[[u8; 4]]) -> Self {
        debug_assert_eq!(pixels.len(), PIXELS);
        let Some((colours, numbers)) = numbered(pixels) else {
            return Self(Pixels::Each(pixels.into()));
        };
        let numbers = if colours.len() == 1 {
            zeros()
        } else {
            numbers.into()
        };
        Self(Pixels::Numbered {
            colours: colours.into(),
            numbers,
        })
    }

    /// The pixel at column `x`, row `y` of the tile.
    #[inline]
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 4] {
        let k = y * TILE + x;
        match &self.0 {
            Pixels::Each(pixels) => pixels[k],
            Pixels::Numbered { colours, numbers } => colours[usize::from(numbers[k])],
        }
    }

    /// The colours of the tile's list and the number of each pixel; `None` where there are too many colours for that.
    /// Not every colour of the list need occur.
    pub fn numbered(&self) -> Option<(&[[u8; 4]], &[u8])> {
        match &self.0 {
            Pixels::Each(_) => None,
            Pixels::Numbered { colours, numbers } => Some((colours, numbers)),
        }
    }

    /// Whether both are one tile in memory: then they are equal, else they may be.
    pub fn is(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Pixels::Each(a), Pixels::Each(b)) => Arc::ptr_eq(a, b),
            (
                Pixels::Numbered { colours, numbers },
                Pixels::Numbered {
                    colours: other_colours,
                    numbers: other_numbers,
                },
            ) => Arc::ptr_eq(colours, other_colours) && Arc::ptr_eq(numbers, other_numbers),
            _ => false,
        }
    }

    /// Whether the first `width` × `height` pixels are equal.
    pub(super) fn equals(&self, other: &Self, width: usize, height: usize) -> bool {
        if self.is(other) {
            return true;
        }
        if let (
            Pixels::Numbered { colours, numbers },
            Pixels::Numbered {
                colours: other_colours,
                numbers: other_numbers,
            },
        ) = (&self.0, &other.0)
            && colours == other_colours
            && (Arc::ptr_eq(numbers, other_numbers) || numbers == other_numbers)
        {
            return true;
        }
        (0..height).all(|y| (0..width).all(|x| self.pixel(x, y) == other.pixel(x, y)))
    }

    /// Bytes of memory that this tile takes and `other` does not share.
    pub(super) fn bytes_beside(&self, other: Option<&Self>) -> usize {
        let taken = |own: usize, is_shared: bool| if is_shared { 0 } else { own };
        match (&self.0, other.map(|other| &other.0)) {
            (Pixels::Each(a), Some(Pixels::Each(b))) => taken(size_of_val(&**a), Arc::ptr_eq(a, b)),
            (Pixels::Each(a), _) => size_of_val(&**a),
            (Pixels::Numbered { colours, numbers }, other) => {
                let (same_colours, same_numbers) = match other {
                    Some(Pixels::Numbered {
                        colours: other_colours,
                        numbers: other_numbers,
                    }) => (
                        Arc::ptr_eq(colours, other_colours),
                        Arc::ptr_eq(numbers, other_numbers),
                    ),
                    _ => (false, false),
                };
                let same_numbers = same_numbers || Arc::ptr_eq(numbers, &zeros());
                taken(size_of_val(&**colours), same_colours)
                    + taken(size_of_val(&**numbers), same_numbers)
            }
        }
    }

    /// Gives columns `from..to` of row `y` a colour.
    pub(super) fn fill(&mut self, y: usize, from: usize, to: usize, colour: [u8; 4]) {
        let place = y * TILE + from..y * TILE + to;
        if let Pixels::Numbered { colours, .. } = &self.0
            && colours.len() == MOST_COLOURS
            && !colours.contains(&colour)
        {
            // Painting may have left colours in the list that no pixel has any more.
            let pixels = self.unpacked();
            *self = Self::new(&pixels);
            if matches!(&self.0, Pixels::Numbered { colours, .. } if colours.len() == MOST_COLOURS)
            {
                self.0 = Pixels::Each(pixels.into());
            }
        }
        match &mut self.0 {
            Pixels::Each(pixels) => Arc::make_mut(pixels)[place].fill(colour),
            Pixels::Numbered { colours, numbers } => {
                let known = colours.iter().position(|&known| known == colour);
                let number = known.unwrap_or(colours.len()) as u8;
                if known.is_none() {
                    *colours = colours.iter().copied().chain([colour]).collect();
                }
                if numbers[place.clone()].iter().any(|&old| old != number) {
                    Arc::make_mut(numbers)[place].fill(number);
                }
            }
        }
    }

    /// The tile with every colour replaced.
    pub(super) fn mapped(&self, mut map: impl FnMut([u8; 4]) -> [u8; 4]) -> Self {
        match &self.0 {
            Pixels::Each(_) => {
                let mut pixels = self.unpacked();
                let mut last = (pixels[0], map(pixels[0]));
                let mut differs = false;
                for pixel in &mut pixels {
                    if *pixel != last.0 {
                        last = (*pixel, map(*pixel));
                    }
                    differs |= last.0 != last.1;
                    *pixel = last.1;
                }
                if differs {
                    Self::new(&pixels)
                } else {
                    self.clone()
                }
            }
            Pixels::Numbered { colours, numbers } => {
                let mapped: Arc<[[u8; 4]]> = colours.iter().copied().map(map).collect();
                if mapped == *colours {
                    return self.clone();
                }
                Self(Pixels::Numbered {
                    colours: mapped,
                    numbers: Arc::clone(numbers),
                })
            }
        }
    }

    fn unpacked(&self) -> Vec<[u8; 4]> {
        match &self.0 {
            Pixels::Each(pixels) => pixels.to_vec(),
            Pixels::Numbered { colours, numbers } => numbers
                .iter()
                .map(|&number| colours[usize::from(number)])
                .collect(),
        }
    }
}

/// The colours of pixels in the order they first occur, and the number of each pixel; `None` if there are too many.
fn numbered(pixels: &[[u8; 4]]) -> Option<(Vec<[u8; 4]>, Vec<u8>)> {
    // Open addressing with room to spare; 0 is empty, else the number of a colour and one.
    const SLOTS: usize = 1024;
    let mut slots = [0_u16; SLOTS];
    let mut colours: Vec<[u8; 4]> = Vec::new();
    let mut numbers = Vec::with_capacity(pixels.len());
    let mut last: Option<([u8; 4], u8)> = None;
    for &pixel in pixels {
        if let Some((colour, number)) = last
            && colour == pixel
        {
            numbers.push(number);
            continue;
        }
        let mut slot = (u32::from_le_bytes(pixel).wrapping_mul(0x9E37_79B1) >> 22) as usize;
        let number = loop {
            match slots[slot] {
                0 => {
                    if colours.len() == MOST_COLOURS {
                        return None;
                    }
                    colours.push(pixel);
                    slots[slot] = colours.len() as u16;
                    break colours.len() - 1;
                }
                known if colours[usize::from(known) - 1] == pixel => break usize::from(known) - 1,
                _ => slot = (slot + 1) % SLOTS,
            }
        };
        numbers.push(number as u8);
        last = Some((pixel, number as u8));
    }
    Some((colours, numbers))
}
