//! Opening a window on the graphics device, as the designer needs it.

use std::sync::Arc;

use anyhow::anyhow;
use eframe::CreationContext;
use egui::ViewportCommand;
use renderer_core::gpu::wanted_features;
use renderer_core::render::MAX_SIDE;
use wgpu::rwh::{HasDisplayHandle, RawDisplayHandle};

use super::system_fonts::use_system_fonts;
use crate::designer::widgets::cannot_take_drops;

/// Smallest size of the window, points: with its frame it fits a screen of 1366 × 768 pixels at scale 1.5.
pub const SMALLEST_WINDOW: [f32; 2] = [880.0, 440.0];

/// Opens a window of the designer's size with what `create` makes, and returns when it is closed.
///
/// # Errors
/// When no window can be opened, with what to install.
pub fn in_a_window(
    create: impl FnOnce(&CreationContext<'_>) -> Box<dyn eframe::App>,
) -> anyhow::Result<()> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("towel-designer")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size(SMALLEST_WINDOW),
        wgpu_options: wgpu_options(),
        // Ours are used instead.
        system_font_fallback: false,
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        use_system_fonts(&cc.egui_ctx);
        Ok(create(cc))
    });
    eframe::run_native("Towel Designer", options, create).map_err(|error| {
        anyhow!(
            "the window cannot be opened: {error}; without a display use `towel-designer render`, and on Debian and \
             Ubuntu install mesa-vulkan-drivers, libxkbcommon-x11-0, libxcursor1 and libxi6"
        )
    })
}

/// eframe's device with the adapter's own limits: egui-wgpu would ask for 8192 pixels of texture whatever there is.
fn wgpu_options() -> egui_wgpu::WgpuConfiguration {
    let mut setup = egui_wgpu::WgpuSetupCreateNew::without_display_handle();
    setup.device_descriptor = Arc::new(|adapter| wgpu::DeviceDescriptor {
        label: Some("designer"),
        required_features: wanted_features(adapter),
        required_limits: adapter.limits(),
        ..Default::default()
    });
    egui_wgpu::WgpuConfiguration {
        wgpu_setup: egui_wgpu::WgpuSetup::CreateNew(setup),
        ..Default::default()
    }
}

/// Notes where the window cannot take dropped files.
pub fn note_drops(cc: &CreationContext<'_>) {
    let display = cc.display_handle().map(|display| display.as_raw());
    if matches!(display, Ok(RawDisplayHandle::Wayland(_))) {
        cannot_take_drops(&cc.egui_ctx);
    }
}

/// A window larger than its device's textures could not be drawn at all.
pub fn keep_to_textures(cc: &CreationContext<'_>) {
    let Some(state) = &cc.wgpu_render_state else {
        return;
    };
    let limit = state.device.limits().max_texture_dimension_2d;
    if limit < MAX_SIDE {
        let scale = cc.egui_ctx.native_pixels_per_point().unwrap_or(1.0);
        let most = egui::Vec2::splat(limit as f32 / scale);
        let command = ViewportCommand::MaxInnerSize(most);
        cc.egui_ctx.send_viewport_cmd(command);
    }
}
