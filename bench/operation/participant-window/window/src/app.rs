//! The window's event loop: monitor, ruler page, session, keys, frames.

use std::num::NonZeroU32;
use std::rc::Rc;
use std::time::{Duration, Instant};

use softbuffer::{Context, Rect, Surface};
use winit::application::ApplicationHandler;
use winit::event::{ElementState, KeyEvent, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::window::{Fullscreen, Window, WindowId};

use crate::error::WindowError;
use crate::link::Link;
use crate::monitor;
use crate::options::Options;
use crate::stage::Stage;
use participant_window::canvas::Canvas;
use participant_window::fitness::OnMonitor;
use participant_window::geometry::Geometry;
use participant_window::lettering::Typeface;
use participant_window::message::{Display, FORMAT};
use participant_window::page::{Moving, ParticipantPage};
use participant_window::place::shared_s;
use participant_window::ruler::{ASSUMED_PIXEL_M, Ruler};
use participant_window::scales::Scales;

/// The window.
pub struct App {
    options: Options,
    face: Typeface,
    scales: Scales,
    link: Link,
    stage: Stage,
    screen: Option<Screen>,
    ruler: Option<Ruler>,
    modifiers: ModifiersState,
    error: Option<WindowError>,
}

/// The window on its monitor.
struct Screen {
    surface: Surface<Rc<Window>, Rc<Window>>,
    page: ParticipantPage,
    display: Display,
    chosen_monitor: OnMonitor,
    /// Time at which the next frame is due.
    next_frame: Instant,
    /// Time from the start of a frame to its presentation, s.
    lead_s: f64,
    moving: Moving,
    /// Whether the whole window must be drawn anew.
    stale: bool,
}

fn failed(error: impl std::fmt::Display) -> WindowError {
    WindowError::Failed(error.to_string())
}

impl App {
    pub fn new(options: Options, face: Typeface, scales: Scales) -> Self {
        Self {
            link: Link::new(options.socket.clone()),
            options,
            face,
            scales,
            stage: Stage::default(),
            screen: None,
            ruler: None,
            modifiers: ModifiersState::empty(),
            error: None,
        }
    }

    /// Returns the error that ended the window, if any.
    pub fn into_error(self) -> Option<WindowError> {
        self.error
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), WindowError> {
        let monitor = monitor::choose(events, self.options.monitor.as_deref())?;
        let size = monitor.size();
        // Without a window manager the window is not resized, so it starts as large as the monitor.
        let attributes = Window::default_attributes()
            .with_title("friction-bench: participant")
            .with_decorations(false)
            .with_inner_size(size)
            .with_position(monitor.position())
            .with_fullscreen(Some(Fullscreen::Borderless(Some(monitor.clone()))));
        let window = Rc::new(events.create_window(attributes).map_err(failed)?);
        window.set_cursor_visible(false);
        let context = Context::new(window.clone()).map_err(failed)?;
        let surface = Surface::new(&context, window.clone()).map_err(failed)?;
        let name = monitor::name(&monitor);
        let stored_m = self.scales.pixel_m(&name, (size.width, size.height));
        let pixel_m = stored_m.unwrap_or(ASSUMED_PIXEL_M);
        if self.options.ruler || stored_m.is_none() {
            self.ruler = Some(Ruler::new(size.width, pixel_m));
        }
        let display = Display {
            format: FORMAT,
            virtual_display: monitor::is_virtual(&name),
            monitor: name,
            width_px: size.width.max(1),
            height_px: size.height.max(1),
            pixel_m,
            refresh_s: monitor::refresh_s(&monitor),
        };
        let page = ParticipantPage::new(self.face.clone(), geometry(&display));
        self.screen = Some(Screen {
            surface,
            page,
            display,
            chosen_monitor: monitor::identity(&monitor),
            next_frame: Instant::now(),
            lead_s: 0.0,
            moving: Moving::default(),
            stale: true,
        });
        Ok(())
    }

    /// Draws the frame that is due; returns the time of the next.
    fn frame(&mut self) -> Result<Option<Instant>, WindowError> {
        let Some(screen) = &mut self.screen else {
            return Ok(None);
        };
        let now = Instant::now();
        if now < screen.next_frame {
            return Ok(Some(screen.next_frame));
        }
        let refresh = Duration::from_secs_f64(screen.display.refresh_s);
        // Late frames are not made up for.
        screen.next_frame = (screen.next_frame + refresh).max(now);
        if let Some(ruler) = &self.ruler {
            if screen.stale {
                screen.show_ruler(ruler, &self.face)?;
            }
            return Ok(Some(screen.next_frame));
        }
        let begun_s = shared_s();
        let news = self.link.look(begun_s, &screen.display);
        for message in news.messages {
            self.stage.take(message);
        }
        match news.lost {
            Some(reason) => self.stage.show_loss(&reason),
            None => self.stage.show_waiting(),
        }
        let refresh_s = screen.display.refresh_s;
        // The slider is drawn where it should be in the middle of the frame's time on the screen.
        let (content, audio_s, moving) = self
            .stage
            .frame_at(begun_s + screen.lead_s + refresh_s / 2.0);
        let moves = self.stage.moves(begun_s);
        screen.show(&content, audio_s, moving, moves)?;
        let presented_s = shared_s();
        if moves {
            screen.lead_s += 0.1 * (presented_s - begun_s - screen.lead_s);
        }
        if let Some(report) = self
            .stage
            .presented(presented_s, moving.slider_m, refresh_s)
        {
            self.link.say(&report);
        }
        let current_monitor = screen.surface.window().current_monitor();
        let current_monitor = current_monitor.as_ref().map(monitor::identity);
        let fit = self.stage.fit(
            presented_s,
            &screen.chosen_monitor,
            current_monitor.as_ref(),
        );
        if let Some(fit) = fit {
            self.link.say(&fit);
        }
        for trouble in self.stage.troubles(screen.page.geometry(), &self.face) {
            self.link.say(&trouble);
        }
        Ok(Some(screen.next_frame))
    }

    fn key(&mut self, events: &ActiveEventLoop, key: &Key) -> Result<(), WindowError> {
        let Some(screen) = &mut self.screen else {
            return Ok(());
        };
        screen.stale = true;
        let control = self.modifiers.control_key();
        match (key, &mut self.ruler) {
            (Key::Character(letter), _) if control && letter.eq_ignore_ascii_case("q") => {
                events.exit()
            }
            (Key::Character(letter), None) if control && letter.eq_ignore_ascii_case("r") => {
                // The ruler page is shown without a session.
                self.link.leave();
                self.stage.show_loss("");
                self.ruler = Some(Ruler::new(screen.display.width_px, screen.display.pixel_m));
            }
            (Key::Named(named_key), Some(ruler)) => match named_key {
                NamedKey::ArrowRight => ruler.adjust(1),
                NamedKey::ArrowLeft => ruler.adjust(-1),
                NamedKey::ArrowUp => ruler.adjust(10),
                NamedKey::ArrowDown => ruler.adjust(-10),
                NamedKey::Escape => self.ruler = None,
                NamedKey::Enter => {
                    let display = &mut screen.display;
                    display.pixel_m = ruler.pixel_m();
                    let size = (display.width_px, display.height_px);
                    self.scales.keep(&display.monitor, size, display.pixel_m)?;
                    screen.page =
                        ParticipantPage::new(self.face.clone(), geometry(&screen.display));
                    self.ruler = None;
                }
                _ => {}
            },
            _ => {}
        }
        Ok(())
    }

    fn end(&mut self, events: &ActiveEventLoop, error: WindowError) {
        self.error = Some(error);
        events.exit();
    }
}

fn geometry(display: &Display) -> Geometry {
    Geometry {
        width: f64::from(display.width_px),
        height: f64::from(display.height_px),
        pixel_m: display.pixel_m,
    }
}

impl Screen {
    fn resized(&mut self, face: &Typeface, width: u32, height: u32) {
        if (width, height) == (self.display.width_px, self.display.height_px)
            || width == 0
            || height == 0
        {
            return;
        }
        (self.display.width_px, self.display.height_px) = (width, height);
        self.page = ParticipantPage::new(face.clone(), geometry(&self.display));
        self.stale = true;
    }

    /// Shows the participant's page if it has changed.
    fn show(
        &mut self,
        content: &participant_window::message::Content,
        audio_s: Option<f64>,
        moving: Moving,
        moves: bool,
    ) -> Result<(), WindowError> {
        let rows = self.page.geometry().moving_rows();
        let (canvas, changed) = self.page.draw(content, audio_s, moving);
        if !(changed || moves || self.stale || moving != self.moving) {
            return Ok(());
        }
        let redraw_all = changed || self.stale;
        present(&mut self.surface, canvas, (!redraw_all).then_some(rows))?;
        self.moving = moving;
        self.stale = false;
        Ok(())
    }

    fn show_ruler(&mut self, ruler: &Ruler, face: &Typeface) -> Result<(), WindowError> {
        let (width, height) = self.page_size();
        let mut canvas = Canvas::new(width, height, 0);
        ruler.draw(&mut canvas, face);
        present(&mut self.surface, &canvas, None)?;
        self.stale = false;
        Ok(())
    }

    fn page_size(&self) -> (usize, usize) {
        (
            self.display.width_px as usize,
            self.display.height_px as usize,
        )
    }
}

/// Copies a picture, or some of its rows, to the window.
fn present(
    surface: &mut Surface<Rc<Window>, Rc<Window>>,
    canvas: &Canvas,
    rows: Option<std::ops::Range<usize>>,
) -> Result<(), WindowError> {
    let (width, height) = canvas.size();
    let edge = |pixels: usize| u32::try_from(pixels).ok().and_then(NonZeroU32::new);
    let (Some(columns), Some(lines)) = (edge(width), edge(height)) else {
        return Ok(());
    };
    surface.resize(columns, lines).map_err(failed)?;
    let mut buffer = surface.buffer_mut().map_err(failed)?;
    // A buffer of another age lacks the frames in between.
    let rows = rows.filter(|_| buffer.age() == 1).unwrap_or(0..height);
    let (first, last) = (rows.start.min(height), rows.end.min(height));
    let pixels = first * width..last * width;
    if let (Some(to), Some(from)) = (buffer.get_mut(pixels.clone()), canvas.pixels().get(pixels)) {
        to.copy_from_slice(from);
    }
    let Some(count) = edge(last - first) else {
        return Ok(());
    };
    let damage = Rect {
        x: 0,
        y: u32::try_from(first).map_err(failed)?,
        width: columns,
        height: count,
    };
    buffer.present_with_damage(&[damage]).map_err(failed)
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.screen.is_none()
            && let Err(error) = self.open(events)
        {
            self.end(events, error);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::RedrawRequested => {
                if let Some(screen) = &mut self.screen {
                    screen.stale = true;
                }
            }
            WindowEvent::Resized(size) => {
                if let Some(screen) = &mut self.screen {
                    screen.resized(&self.face, size.width, size.height);
                }
            }
            WindowEvent::KeyboardInput {
                event:
                    KeyEvent {
                        logical_key,
                        state: ElementState::Pressed,
                        ..
                    },
                ..
            } => {
                if let Err(error) = self.key(events, &logical_key) {
                    self.end(events, error);
                }
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        match self.frame() {
            Ok(Some(next_frame)) => events.set_control_flow(ControlFlow::WaitUntil(next_frame)),
            Ok(None) => events.set_control_flow(ControlFlow::Wait),
            Err(error) => self.end(events, error),
        }
    }
}
