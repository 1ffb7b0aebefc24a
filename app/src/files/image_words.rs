//! What the program calls each image of a design, and which files it is read from: one row an image.

use renderer_core::design::ImageSlot;

/// The words for one image.
#[derive(Debug, Clone, Copy)]
pub struct ImageWords {
    /// What messages call it.
    pub name: &'static str,
    /// The name of its file, without the ending, where it has none of its own.
    pub file_stem: &'static str,
    /// Endings of the files that it is read from, without the dot.
    pub endings: &'static [&'static str],
    /// Endings of files that become it when they are dropped on the window.
    pub dropped_endings: &'static [&'static str],
    /// Title of the dialog that asks for it.
    pub dialog_title: &'static str,
    /// Name under which the folder last used for it is remembered.
    pub folder_key: &'static str,
    /// Heading of the message that it could not be opened.
    pub not_opened: &'static str,
    /// Where it can be painted: the keyword of the PNG text that names the preset its file belongs to.
    pub owner_keyword: Option<&'static str>,
}

/// Pictures of colours.
const FLAT: &[&str] = &[
    "png", "jpg", "jpeg", "webp", "gif", "bmp", "tif", "tiff", "tga", "ppm", "pgm", "pbm", "pnm",
];

const CHART: ImageWords = ImageWords {
    name: "chart image",
    file_stem: "chart",
    endings: FLAT,
    dropped_endings: FLAT,
    dialog_title: "Open chart",
    folder_key: "charts",
    not_opened: "Chart not opened",
    owner_keyword: Some("Towel Designer chart of"),
};

const NAP: ImageWords = ImageWords {
    name: "nap map",
    file_stem: "nap",
    endings: FLAT,
    dropped_endings: &[],
    dialog_title: "Open nap map",
    folder_key: "nap maps",
    not_opened: "Nap map not opened",
    owner_keyword: Some("Towel Designer nap map of"),
};

const ENVIRONMENT: ImageWords = ImageWords {
    name: "environment image",
    file_stem: "surroundings",
    endings: &[
        "hdr", "exr", "pic", "xyze", "png", "jpg", "jpeg", "webp", "gif", "bmp", "tif", "tiff",
        "tga", "ppm", "pgm", "pbm", "pnm",
    ],
    dropped_endings: &["hdr", "exr", "pic", "xyze"],
    dialog_title: "Open surroundings",
    folder_key: "surroundings",
    not_opened: "Surroundings not opened",
    owner_keyword: None,
};

const HEIGHT: ImageWords = ImageWords {
    name: "height picture",
    file_stem: "heights",
    endings: FLAT,
    dropped_endings: &[],
    dialog_title: "Open height picture",
    folder_key: "height pictures",
    not_opened: "Height picture not opened",
    owner_keyword: None,
};

const OBJECT: ImageWords = ImageWords {
    name: "picture on the chart",
    file_stem: "object",
    endings: FLAT,
    dropped_endings: &[],
    dialog_title: "Open picture",
    folder_key: "charts",
    not_opened: "Picture not opened",
    owner_keyword: Some("Towel Designer picture on the chart of"),
};

/// The name of an image's file, without the ending, where it has none of its own.
pub fn file_stem(slot: ImageSlot) -> String {
    match slot {
        ImageSlot::Object(index) => format!("{}-{}", OBJECT.file_stem, index + 1),
        slot => words(slot).file_stem.into(),
    }
}

/// The words for an image.
pub fn words(slot: ImageSlot) -> &'static ImageWords {
    match slot {
        ImageSlot::Chart => &CHART,
        ImageSlot::Nap => &NAP,
        ImageSlot::Environment => &ENVIRONMENT,
        ImageSlot::Height => &HEIGHT,
        ImageSlot::Object(_) => &OBJECT,
    }
}

/// The image that a file of this ending (lower case, without the dot) becomes when it is dropped on the window.
pub fn dropped(ending: &str) -> Option<ImageSlot> {
    let mut slots = ImageSlot::ALL.into_iter();
    slots.find(|slot| words(*slot).dropped_endings.contains(&ending))
}
