//! Widgets that know numbers, choices, colours, grids, curves and icons, but no towels.

mod choice_row;
mod curve_editor;
mod file_browser;
mod grid_editor;
mod icon;
mod icon_button;
mod keys;
mod number_row;
mod pointer_way;
mod row;
pub mod shapes;
mod thumbnail;
mod toggle;

pub use choice_row::{Choice, check, choice, colour, colour_value};
pub use curve_editor::{CurveEditor, curve_editor};
pub use file_browser::{Browsed, FileBrowser, FileKind};
pub use grid_editor::{GridAccess, GridCell, GridEditor, GridTool, GridView, grid_editor};
pub use icon::Icon;
pub use icon_button::IconButton;
pub use keys::arrow_keys;
pub use number_row::{number, number_value, optional_number};
pub use pointer_way::PointerWay;
pub use row::{label_of, more, row, subheading};
pub use thumbnail::{Thumbnail, show_thumbnail};
pub use toggle::{check_box, colour_well, radio_button};
