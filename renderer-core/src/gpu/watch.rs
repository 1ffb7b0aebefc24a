//! Notices when a device is lost (driver reset, card unplugged, machine resumed from sleep) and what it refuses outside
//! of error scopes. Without this wgpu would panic on the latter and say nothing of the former: it drops the work of a
//! lost device silently.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Called when a device is lost.
type Alarm = Box<dyn Fn() + Send + Sync>;

/// Watches one device. Clones share what they know.
#[derive(Clone)]
pub struct DeviceWatch(Arc<State>);

struct State {
    lost: OnceLock<String>,
    refused: Mutex<Option<String>>,
    alarm: Alarm,
}

impl std::fmt::Debug for DeviceWatch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("DeviceWatch").field(&self.lost()).finish()
    }
}

impl DeviceWatch {
    /// Watches `device` from now on, instead of any earlier watch.
    pub fn new(device: &wgpu::Device) -> Self {
        Self::with_alarm(device, || {})
    }

    /// Watches `device`; calls `alarm`, on any thread, when the device is lost or refuses something.
    pub fn with_alarm(device: &wgpu::Device, alarm: impl Fn() + Send + Sync + 'static) -> Self {
        let watch = Self(Arc::new(State {
            lost: OnceLock::new(),
            refused: Mutex::default(),
            alarm: Box::new(alarm),
        }));
        let state = Arc::clone(&watch.0);
        device.set_device_lost_callback(move |reason, message| {
            let text = if message.is_empty() {
                format!("{reason:?}").to_lowercase()
            } else {
                message
            };
            // Only the first loss matters.
            let _ = state.lost.set(text);
            (state.alarm)();
        });
        let state = Arc::clone(&watch.0);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            tracing::error!("{error}");
            let mut refused = state.refused.lock().unwrap_or_else(PoisonError::into_inner);
            refused.get_or_insert_with(|| error.to_string());
            drop(refused);
            (state.alarm)();
        }));
        watch
    }

    /// Why the device is lost, if it is.
    pub fn lost(&self) -> Option<&str> {
        self.0.lost.get().map(String::as_str)
    }

    /// What the device refused first since this was last asked.
    pub fn take_refused(&self) -> Option<String> {
        let refused = self.0.refused.lock();
        refused.unwrap_or_else(PoisonError::into_inner).take()
    }
}
