//! What JPEG files have that their decoder keeps to itself: whether they are whole, and inks.

use image::{DynamicImage, RgbaImage};

/// What the segments of a JPEG say.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Survey {
    /// Width and height, pixels.
    size: [u16; 2],
    /// Channels.
    components: u8,
    /// How an Adobe segment says the channels are coded: 0 as they are, 1 YCbCr, 2 YCCK.
    pub(super) adobe_transform: Option<u8>,
    /// Whether parts of a colour profile are there.
    pub(super) has_profile: bool,
    /// Whether the end of the picture is there.
    pub(super) is_whole: bool,
}

/// Walks through the segments of a JPEG.
pub(super) fn survey(bytes: &[u8]) -> Survey {
    let mut survey = Survey::default();
    let mut at = 2;
    while let Some(marker) = next_marker(bytes, &mut at) {
        match marker {
            0xd9 => {
                survey.is_whole = true;
                break;
            }
            // Without content: start of image, restarts, and one that is reserved.
            0xd8 | 0xd0..=0xd7 | 0x01 => continue,
            _ => {}
        }
        let Some(&[high, low]) = bytes.get(at..).and_then(<[u8]>::first_chunk) else {
            break;
        };
        let length = usize::from(u16::from_be_bytes([high, low])).max(2);
        let content = bytes.get(at + 2..at + length).unwrap_or_default();
        at += length;
        match marker {
            0xc4 | 0xc8 | 0xcc => {}
            0xc0..=0xcf => {
                if let Some(&[_, h0, h1, w0, w1, components]) = content.first_chunk() {
                    survey.size = [[w0, w1], [h0, h1]].map(u16::from_be_bytes);
                    survey.components = components;
                }
            }
            0xe2 => survey.has_profile |= content.starts_with(b"ICC_PROFILE\0"),
            0xee if content.starts_with(b"Adobe") => {
                survey.adobe_transform = content.get(11).copied();
            }
            _ => {}
        }
    }
    survey
}

/// The next marker from `at` on, which is moved behind it. What codes pixels is passed over: there a byte of ones is
/// followed by 0.
fn next_marker(bytes: &[u8], at: &mut usize) -> Option<u8> {
    loop {
        let found = bytes.get(*at..)?.iter().position(|&byte| byte == 0xff)?;
        *at += found + 1;
        match *bytes.get(*at)? {
            // Filling; the marker itself may follow.
            0xff => {}
            0 => *at += 1,
            marker => {
                *at += 1;
                return Some(marker);
            }
        }
    }
}

impl Survey {
    /// A TIFF around a JPEG of four inks: the decoder of that format hands its channels over as they are, that of this
    /// one only as an estimate of colours. `None` for a JPEG of other channels.
    pub(super) fn inks_as_tiff(&self, jpeg: &[u8]) -> Option<Vec<u8>> {
        /// The header and a directory of nine entries.
        const START: u32 = 8 + 2 + 9 * 12 + 4;
        if self.components != 4 {
            return None;
        }
        let [width, height] = self.size.map(u32::from);
        let length = u32::try_from(jpeg.len()).ok()?;
        let entries: [(u16, u32); 9] = [
            (256, width),
            (257, height),
            (258, 8),
            (259, 7),
            (262, 2),
            (273, START),
            (277, 4),
            (278, height),
            (279, length),
        ];
        let mut file = b"II*\0\x08\0\0\0\x09\0".to_vec();
        for (tag, value) in entries {
            file.extend(tag.to_le_bytes());
            // One number of 32 bits.
            file.extend(4_u16.to_le_bytes());
            file.extend(1_u32.to_le_bytes());
            file.extend(value.to_le_bytes());
        }
        file.extend([0; 4]);
        file.extend(jpeg);
        Some(file)
    }
}

/// The inks of a JPEG from its channels, from 0, none, to 255. Programs that write an Adobe segment write them
/// inverted, the first three as YCbCr where its transform is 2.
pub(super) fn inks(mut channels: RgbaImage, adobe_transform: Option<u8>) -> DynamicImage {
    channels.pixels_mut().for_each(|pixel| {
        pixel.0 = match (adobe_transform, pixel.0) {
            (None, inks) => inks,
            (Some(2), [y, cb, cr, black]) => {
                // What is inverted twice: YCbCr of what the inks leave, and that inverted.
                let [c, m, y] = rgb_of_ycbcr([y, cb, cr]);
                [c, m, y, 255 - black]
            }
            (Some(_), inverted) => inverted.map(|ink| 255 - ink),
        };
    });
    channels.into()
}

/// As JFIF has it.
fn rgb_of_ycbcr(coded: [u8; 3]) -> [u8; 3] {
    let [y, cb, cr] = coded.map(f32::from);
    let (cb, cr) = (cb - 128.0, cr - 128.0);
    [
        y + 1.402 * cr,
        y - 0.344_136 * cb - 0.714_136 * cr,
        y + 1.772 * cb,
    ]
    .map(|value| value.round().clamp(0.0, 255.0) as u8)
}
