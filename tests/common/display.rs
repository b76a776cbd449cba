//! An X server for a test, with its mouse and its screen.

use eframe::egui::Pos2;
use image::RgbImage;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{ConnectionExt, ImageFormat};
use x11rb::rust_connection::RustConnection;

/// Is this program on PATH?
pub fn is_installed(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

/// A child process that ends with its owner, also when a test fails.
pub struct Child(std::process::Child);

impl Child {
    pub fn start(command: &mut Command) -> Self {
        Self(command.spawn().unwrap())
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // It may be over already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A running X server; it ends when this is dropped.
pub struct Display {
    name: String,
    connection: RustConnection,
    _server: Child,
}

impl Display {
    /// A server on the first free display, with one screen.
    pub fn start([width, height]: [u16; 2]) -> Self {
        let screen = format!("{width}x{height}x24");
        let mut command = Command::new("Xvfb");
        command
            .args(["-displayfd", "1", "-screen", "0", &screen])
            .args(["-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut server = Child::start(&mut command);
        let mut line = String::new();
        let pipe = server.0.stdout.take().unwrap();
        // The server writes its number when it is ready, or ends.
        BufReader::new(pipe).read_line(&mut line).unwrap();
        let name = format!(":{}", line.trim());
        let (connection, _) = x11rb::connect(Some(&name))
            .unwrap_or_else(|error| panic!("the X server {name} does not answer: {error}"));
        Self {
            name,
            connection,
            _server: server,
        }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// A screenshot of the whole screen.
    pub fn screenshot(&self) -> RgbImage {
        let screen = &self.connection.setup().roots[0];
        let (width, height) = (screen.width_in_pixels, screen.height_in_pixels);
        let format = ImageFormat::Z_PIXMAP;
        let request = self
            .connection
            .get_image(format, screen.root, 0, 0, width, height, u32::MAX);
        let bytes = request.unwrap().reply().unwrap().data;
        RgbImage::from_fn(width.into(), height.into(), |x, y| {
            let at = ((y * u32::from(width) + x) * 4) as usize;
            image::Rgb([bytes[at + 2], bytes[at + 1], bytes[at]])
        })
    }

    /// Moves the mouse and clicks.
    pub fn click(&self, at: Pos2) {
        let place = [at.x, at.y].map(|v| format!("{v:.0}"));
        let status = Command::new("xdotool")
            .env("DISPLAY", &self.name)
            .args(["mousemove", "--sync", &place[0], &place[1]])
            .args(["sleep", "0.2", "click", "1"])
            .status()
            .unwrap();
        assert!(status.success(), "xdotool failed");
    }
}
