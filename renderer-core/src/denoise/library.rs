//! The C interface of Open Image Denoise 2.x, loaded at run time: all of its `unsafe` code is here.
//!
//! What is declared here follows the library's documentation (section "API"): opaque handles that are made and
//! released, parameters by name, and errors that are kept for each device until they are asked for. All functions may
//! be called from any thread. Safe types around the handles keep what each needs alive: a filter its buffers, all of
//! them their device, the device its library.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};
use std::ptr::{NonNull, null_mut};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::DenoiseError;

/// `OIDN_DEVICE_TYPE_DEFAULT`: what the library takes for the fastest.
pub const DEFAULT_DEVICE: c_int = 0;
/// `OIDN_DEVICE_TYPE_CPU`.
pub const CPU_DEVICE: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;
/// `OIDN_ERROR_CANCELLED`.
const CANCELLED: c_int = 6;
/// Bytes of a pixel of [`FLOAT3`].
const PIXEL_BYTES: usize = 3 * size_of::<f32>();
/// The versions whose interface this is: from 2.0.0 up to below 3.0.0, as the library counts them.
const VERSIONS: std::ops::Range<c_int> = 20_000..30_000;

type Handle = *mut c_void;
type Monitor = unsafe extern "C" fn(*mut c_void, f64) -> bool;

/// Declares the functions that are used, and how they are found in a library.
macro_rules! functions {
    ($($field:ident $symbol:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        struct Functions {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            #[allow(unsafe_code, reason = "symbols of a C library")]
            fn find(library: &libloading::Library, path: &Path) -> Result<Self, DenoiseError> {
                Ok(Self {
                    $($field: {
                        // SAFETY: the type is that of the symbol in every version 2 of the library; that it is one is
                        // checked before any function but those that tell the version is called.
                        let found = unsafe { library.get(concat!($symbol, "\0").as_bytes()) };
                        *found.map_err(|_| DenoiseError::Symbol {
                            path: path.to_owned(),
                            symbol: $symbol,
                        })?
                    },)*
                })
            }
        }
    };
}

functions! {
    new_device "oidnNewDevice": fn(c_int) -> Handle;
    commit_device "oidnCommitDevice": fn(Handle);
    release_device "oidnReleaseDevice": fn(Handle);
    device_error "oidnGetDeviceError": fn(Handle, *mut *const c_char) -> c_int;
    device_int "oidnGetDeviceInt": fn(Handle, *const c_char) -> c_int;
    set_device_bool "oidnSetDeviceBool": fn(Handle, *const c_char, bool);
    physical_devices "oidnGetNumPhysicalDevices": fn() -> c_int;
    physical_int "oidnGetPhysicalDeviceInt": fn(c_int, *const c_char) -> c_int;
    physical_string "oidnGetPhysicalDeviceString": fn(c_int, *const c_char) -> *const c_char;
    new_buffer "oidnNewBuffer": fn(Handle, usize) -> Handle;
    write_buffer "oidnWriteBuffer": fn(Handle, usize, usize, *const c_void);
    read_buffer "oidnReadBuffer": fn(Handle, usize, usize, *mut c_void);
    release_buffer "oidnReleaseBuffer": fn(Handle);
    new_filter "oidnNewFilter": fn(Handle, *const c_char) -> Handle;
    set_image "oidnSetFilterImage":
        fn(Handle, *const c_char, Handle, c_int, usize, usize, usize, usize, usize);
    set_bool "oidnSetFilterBool": fn(Handle, *const c_char, bool);
    set_int "oidnSetFilterInt": fn(Handle, *const c_char, c_int);
    set_float "oidnSetFilterFloat": fn(Handle, *const c_char, f32);
    set_monitor "oidnSetFilterProgressMonitorFunction": fn(Handle, Option<Monitor>, *mut c_void);
    commit_filter "oidnCommitFilter": fn(Handle);
    execute_filter "oidnExecuteFilter": fn(Handle);
    release_filter "oidnReleaseFilter": fn(Handle);
}

/// Open Image Denoise, loaded.
pub struct Library {
    functions: Functions,
    path: PathBuf,
    /// Never unloaded: threads that it has started may still be in its code.
    _library: ManuallyDrop<libloading::Library>,
}

impl std::fmt::Debug for Library {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Library").field(&self.path).finish()
    }
}

impl Library {
    /// Loads the library; a bare name is looked for where the system looks for libraries.
    ///
    /// # Errors
    /// When the file cannot be loaded, or lacks one of the functions.
    pub fn open(path: &Path) -> Result<Arc<Self>, DenoiseError> {
        let library = load(path).map_err(|error| DenoiseError::Load {
            path: path.to_owned(),
            // The loader's own sentence, which says what the file lacks, is one level down.
            reason: std::error::Error::source(&error)
                .map_or_else(|| error.to_string(), ToString::to_string),
        })?;
        let library = ManuallyDrop::new(library);
        Ok(Arc::new(Self {
            functions: Functions::find(&library, path)?,
            path: path.to_owned(),
            _library: library,
        }))
    }

    /// The file, or the bare name that the system found.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

#[cfg(not(windows))]
#[allow(unsafe_code, reason = "loading a library runs its initialisers")]
fn load(path: &Path) -> Result<libloading::Library, libloading::Error> {
    // SAFETY: what the file does when it is loaded is its own affair, as with any program that the user has installed.
    unsafe { libloading::Library::new(path) }
}

/// As Windows does for programs: what a library needs lies beside it.
#[cfg(windows)]
#[allow(unsafe_code, reason = "loading a library runs its initialisers")]
fn load(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
    if path.is_absolute() {
        // SAFETY: as on other systems.
        let library = unsafe { Library::load_with_flags(path, LOAD_WITH_ALTERED_SEARCH_PATH) };
        return library.map(Into::into);
    }
    // SAFETY: as on other systems.
    unsafe { libloading::Library::new(path) }
}

/// A processor or GPU that the library computes on.
pub struct Device {
    library: Arc<Library>,
    handle: NonNull<c_void>,
}

#[allow(unsafe_code, reason = "a handle of a C library")]
// SAFETY: "all API functions are thread-safe", says the documentation, and the handle belongs to no thread.
unsafe impl Send for Device {}
#[allow(unsafe_code, reason = "a handle of a C library")]
// SAFETY: for the same reason.
unsafe impl Sync for Device {}

#[allow(unsafe_code, reason = "calls of a C library")]
impl Device {
    /// Makes the device of a type ready; the library's threads stay where the system puts them.
    ///
    /// # Errors
    /// What the library says, or when it is of another version.
    pub fn new(library: &Arc<Library>, kind: c_int) -> Result<Self, DenoiseError> {
        let functions = &library.functions;
        // SAFETY: the call takes no pointer.
        let handle = unsafe { (functions.new_device)(kind) };
        let Some(handle) = NonNull::new(handle) else {
            return Err(error_of(library, null_mut()).unwrap_or_else(|| unnamed(library)));
        };
        let device = Self {
            library: Arc::clone(library),
            handle,
        };
        let version = device.int(c"version");
        if !VERSIONS.contains(&version) {
            return Err(DenoiseError::Version {
                path: library.path.clone(),
                version: version_text(version),
            });
        }
        // SAFETY: the handle is that of a device, which lives as long as `device`; the name ends with a zero.
        unsafe {
            // Only processors have this, and others take no harm.
            if device.kind() == CPU_DEVICE {
                (functions.set_device_bool)(handle.as_ptr(), c"setAffinity".as_ptr(), false);
            }
            (functions.commit_device)(handle.as_ptr());
        }
        device.check()?;
        Ok(device)
    }

    fn int(&self, name: &CStr) -> c_int {
        // SAFETY: the handle is alive, the name ends with a zero.
        unsafe { (self.library.functions.device_int)(self.handle.as_ptr(), name.as_ptr()) }
    }

    /// The library's version, as in 2.5.1.
    pub fn version(&self) -> String {
        version_text(self.int(c"version"))
    }

    /// Its type, as the library numbers them.
    pub fn kind(&self) -> c_int {
        self.int(c"type")
    }

    /// The name of the first processor or GPU of its type.
    pub fn hardware(&self) -> Option<String> {
        let functions = &self.library.functions;
        let kind = self.kind();
        // SAFETY: numbers below the count are those of devices; names end with zeros, and so does what is returned, which
        // the library keeps.
        unsafe {
            let count = (functions.physical_devices)();
            let is_ours = |&id: &c_int| (functions.physical_int)(id, c"type".as_ptr()) == kind;
            let id = (0..count).find(is_ours)?;
            let name = (functions.physical_string)(id, c"name".as_ptr());
            (!name.is_null()).then(|| CStr::from_ptr(name).to_string_lossy().trim().to_owned())
        }
    }

    /// The error that has come up on this device since it was last asked.
    fn check(&self) -> Result<(), DenoiseError> {
        error_of(&self.library, self.handle.as_ptr()).map_or(Ok(()), Err)
    }
}

impl Drop for Device {
    #[allow(unsafe_code, reason = "a call of a C library")]
    fn drop(&mut self) {
        // SAFETY: the handle is released once, and what was made of the device keeps it alive by itself.
        unsafe { (self.library.functions.release_device)(self.handle.as_ptr()) };
    }
}

/// `2.5.1` of 20501.
fn version_text(version: c_int) -> String {
    let [major, minor, patch] = [version / 10_000, version / 100 % 100, version % 100];
    format!("{major}.{minor}.{patch}")
}

/// What went wrong on a device, or, with none, in making one on this thread.
#[allow(unsafe_code, reason = "a call of a C library")]
fn error_of(library: &Library, device: Handle) -> Option<DenoiseError> {
    let mut message = std::ptr::null();
    // SAFETY: a device or null is asked for, and `message` takes a text that the library keeps until the next call.
    let (code, text) = unsafe {
        let code = (library.functions.device_error)(device, &raw mut message);
        let text = (!message.is_null()).then(|| CStr::from_ptr(message).to_string_lossy());
        (code, text.map(std::borrow::Cow::into_owned))
    };
    match code {
        0 => None,
        CANCELLED => Some(DenoiseError::Cancelled),
        code => Some(DenoiseError::Failed(
            text.filter(|text| !text.is_empty())
                .unwrap_or_else(|| format!("error {code}")),
        )),
    }
}

fn unnamed(library: &Library) -> DenoiseError {
    DenoiseError::Failed(format!("{} gives no reason", library.path.display()))
}

/// A filter for colours of one size, with the buffers that it reads and writes.
pub struct Filter {
    size: [u32; 2],
    colour: NonNull<c_void>,
    output: NonNull<c_void>,
    handle: NonNull<c_void>,
    device: Arc<Device>,
}

#[allow(unsafe_code, reason = "handles of a C library")]
// SAFETY: as for `Device`.
unsafe impl Send for Filter {}

#[allow(unsafe_code, reason = "calls of a C library")]
impl Filter {
    /// The filter "RT" for light of any brightness, at the library's number for a quality.
    ///
    /// # Errors
    /// What the library says, as when its device has no memory left.
    pub fn new(device: &Arc<Device>, size: [u32; 2], quality: c_int) -> Result<Self, DenoiseError> {
        let functions = &device.library.functions;
        let [width, height] = size.map(|side| side as usize);
        let owner = device.handle.as_ptr();
        let made = |handle: Handle| {
            NonNull::new(handle).ok_or_else(|| match device.check() {
                Err(error) => error,
                Ok(()) => unnamed(&device.library),
            })
        };
        // SAFETY: all handles are alive; names end with zeros; images lie within their buffers, which the filter keeps
        // alive. What has been made before a failure is released.
        unsafe {
            let bytes = width * height * PIXEL_BYTES;
            let colour = made((functions.new_buffer)(owner, bytes))?;
            let release = |buffer: NonNull<c_void>| (functions.release_buffer)(buffer.as_ptr());
            let output =
                made((functions.new_buffer)(owner, bytes)).inspect_err(|_| release(colour))?;
            let handle = made((functions.new_filter)(owner, c"RT".as_ptr())).inspect_err(|_| {
                release(colour);
                release(output);
            })?;
            let filter = Self {
                size,
                colour,
                output,
                handle,
                device: Arc::clone(device),
            };
            for (name, buffer) in [(c"color", colour), (c"output", output)] {
                let (to, from) = (handle.as_ptr(), buffer.as_ptr());
                (functions.set_image)(to, name.as_ptr(), from, FLOAT3, width, height, 0, 0, 0);
            }
            (functions.set_bool)(handle.as_ptr(), c"hdr".as_ptr(), true);
            (functions.set_int)(handle.as_ptr(), c"quality".as_ptr(), quality);
            (functions.commit_filter)(handle.as_ptr());
            device.check()?;
            Ok(filter)
        }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Denoises linear colours, row by row, in place. Values times `scale` are what a picture of usual brightness has.
    ///
    /// # Errors
    /// What the library says; [`DenoiseError::Cancelled`] soon after `cancel` has become true.
    pub fn run(
        &mut self,
        colours: &mut [[f32; 3]],
        scale: f32,
        cancel: &AtomicBool,
    ) -> Result<(), DenoiseError> {
        let [width, height] = self.size.map(|side| side as usize);
        if colours.len() != width * height {
            let count = colours.len();
            let text = format!("{count} colours are given for {width}x{height} pixels");
            return Err(DenoiseError::Failed(text));
        }
        let functions = &self.device.library.functions;
        let (bytes, filter) = (size_of_val(colours), self.handle.as_ptr());
        // SAFETY: the buffers have as many bytes as the colours; `cancel` outlives the execution, which ends before the
        // call returns, and afterwards the filter has no monitor.
        unsafe {
            let flag = std::ptr::from_ref(cancel).cast_mut().cast();
            (functions.write_buffer)(self.colour.as_ptr(), 0, bytes, colours.as_ptr().cast());
            (functions.set_float)(filter, c"inputScale".as_ptr(), scale);
            (functions.set_monitor)(filter, Some(goes_on), flag);
            (functions.commit_filter)(filter);
            (functions.execute_filter)(filter);
            (functions.set_monitor)(filter, None, null_mut());
            self.device.check()?;
            (functions.read_buffer)(self.output.as_ptr(), 0, bytes, colours.as_mut_ptr().cast());
            self.device.check()
        }
    }
}

impl Drop for Filter {
    #[allow(unsafe_code, reason = "calls of a C library")]
    fn drop(&mut self) {
        let functions = &self.device.library.functions;
        // SAFETY: each handle is released once; the library counts who else holds them.
        unsafe {
            (functions.release_filter)(self.handle.as_ptr());
            (functions.release_buffer)(self.colour.as_ptr());
            (functions.release_buffer)(self.output.as_ptr());
        }
    }
}

/// What the library asks from time to time: whether to go on.
#[allow(unsafe_code, reason = "called by a C library")]
unsafe extern "C" fn goes_on(cancel: *mut c_void, _share: f64) -> bool {
    // SAFETY: `Filter::run` gives the address of a flag that lives longer than the call.
    let cancel = unsafe { &*cancel.cast::<AtomicBool>() };
    !cancel.load(Ordering::Relaxed)
}
