//! Drops a file on a window of an X display, as a file manager does when its user lets go of an icon there: the
//! source's side of the XDND protocol, version 5 (freedesktop.org), for one file and one offered type.

use std::path::Path;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    Atom, ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, PropMode,
    SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, SelectionRequestEvent, Window, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;
use x11rb::{COPY_DEPTH_FROM_PARENT, COPY_FROM_PARENT, CURRENT_TIME};

x11rb::atom_manager! {
    Atoms: AtomsCookie {
        XdndSelection, XdndEnter, XdndPosition, XdndStatus, XdndDrop, XdndFinished, XdndActionCopy,
        Type: b"text/uri-list",
    }
}

/// Version of the protocol that is spoken.
const VERSION: u32 = 5;

/// The one who drags.
struct Source<'a> {
    connection: &'a RustConnection,
    atoms: Atoms,
    window: Window,
    target: Window,
}

/// Drags `file` to the position `at` of the screen, pixels, over the window `target`, and drops it there. Panics when
/// the window does not take it within `patience`.
#[track_caller]
pub fn drop_file(display: &str, target: Window, at: [u16; 2], file: &Path, patience: Duration) {
    let (connection, screen) = x11rb::connect(Some(display)).expect("the display answers");
    let root = connection.setup().roots[screen].root;
    let asked = Atoms::new(&connection).expect("the display answers");
    let atoms = asked.reply().expect("atoms");
    let window = connection.generate_id().expect("an id");
    let aux = CreateWindowAux::new();
    connection
        .create_window(
            COPY_DEPTH_FROM_PARENT,
            window,
            root,
            0,
            0,
            1,
            1,
            0,
            WindowClass::INPUT_OUTPUT,
            COPY_FROM_PARENT,
            &aux,
        )
        .expect("a window");
    connection
        .set_selection_owner(window, atoms.XdndSelection, CURRENT_TIME)
        .expect("the selection");
    let source = Source {
        connection: &connection,
        atoms,
        window,
        target,
    };
    source.drag_and_drop(at, &uri(file), patience);
}

impl Source<'_> {
    #[track_caller]
    fn drag_and_drop(&self, [x, y]: [u16; 2], uri: &str, patience: Duration) {
        let atoms = &self.atoms;
        let position = u32::from(x) << 16 | u32::from(y);
        self.tell(atoms.XdndEnter, [VERSION << 24, atoms.Type, 0, 0]);
        let copy = atoms.XdndActionCopy;
        self.tell(atoms.XdndPosition, [0, position, CURRENT_TIME, copy]);
        let (mut accepted, mut given, mut dropped) = (false, false, false);
        let start = Instant::now();
        loop {
            assert!(
                start.elapsed() < patience,
                "the file was not taken: accepted {accepted}, read {given}, dropped {dropped}"
            );
            match self
                .connection
                .poll_for_event()
                .expect("the display answers")
            {
                None => std::thread::sleep(Duration::from_millis(10)),
                Some(Event::SelectionRequest(request)) => {
                    self.give(&request, uri);
                    given = true;
                }
                Some(Event::ClientMessage(message)) if message.type_ == atoms.XdndStatus => {
                    accepted = message.data.as_data32()[1] & 1 == 1;
                    assert!(accepted, "the window refuses files");
                }
                Some(Event::ClientMessage(message)) if message.type_ == atoms.XdndFinished => {
                    return;
                }
                Some(_) => {}
            }
            if accepted && given && !dropped {
                self.tell(atoms.XdndDrop, [0, CURRENT_TIME, 0, 0]);
                dropped = true;
            }
        }
    }

    /// A message to the target; all begin with the source's window.
    fn tell(&self, what: Atom, [a, b, c, d]: [u32; 4]) {
        let message = ClientMessageEvent::new(32, self.target, what, [self.window, a, b, c, d]);
        self.connection
            .send_event(false, self.target, EventMask::NO_EVENT, message)
            .expect("sent");
        self.connection.flush().expect("sent");
    }

    /// Hands the list of files to who asks for it.
    fn give(&self, request: &SelectionRequestEvent, uri: &str) {
        self.connection
            .change_property8(
                PropMode::REPLACE,
                request.requestor,
                request.property,
                self.atoms.Type,
                uri.as_bytes(),
            )
            .expect("given");
        let answer = SelectionNotifyEvent {
            response_type: SELECTION_NOTIFY_EVENT,
            sequence: 0,
            time: request.time,
            requestor: request.requestor,
            selection: request.selection,
            target: request.target,
            property: request.property,
        };
        self.connection
            .send_event(false, request.requestor, EventMask::NO_EVENT, answer)
            .expect("the event is sent");
        self.connection.flush().expect("the event is sent");
    }
}

/// A file as a line of `text/uri-list` (RFC 2483): everything but unreserved characters and slashes escaped.
fn uri(file: &Path) -> String {
    let path = file.canonicalize().expect("a file");
    let mut uri = String::from("file://");
    for byte in path.to_string_lossy().bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                uri.push(byte.into());
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri + "\r\n"
}
