//! Controls that know rows, colours, grids, curves, icons and files, but no towels; and the look of all.

mod colour_picker;
pub mod colour_space;
mod curve_editor;
mod file_browser;
mod file_drop;
mod grid_editor;
mod icon;
mod icon_button;
mod keys;
mod number_field;
mod pointer_way;
mod row;
pub mod shapes;
pub mod style;
mod text;
mod thumbnail;
mod toggle;
mod units;

pub use colour_picker::{colour_well, hex_field};
pub use curve_editor::{CurveEditor, curve_editor};
pub use file_browser::{Browsed, FileBrowser, FileKind};
pub use file_drop::{about_dropping, cannot_take_drops};
pub use grid_editor::{GridAccess, GridCell, GridEditor, GridTool, GridView, grid_editor};
pub use icon::Icon;
pub use icon_button::IconButton;
pub use keys::arrow_keys;
pub use number_field::NumberField;
pub use pointer_way::PointerWay;
pub use row::{fixed_text, more, row, subheading};
pub use text::shortened;
pub use thumbnail::{Thumbnail, show_thumbnail};
pub use toggle::{check_box, radio_button};
pub use units::{UnitSystem, shown_unit};
