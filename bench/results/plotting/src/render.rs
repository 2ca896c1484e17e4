//! Renders figures as SVG and PNG, both with their caption inside.

use std::fmt::Write as _;

use plotters::backend::SVGBackend;
use plotters_backend::DrawingErrorKind;

use crate::bitmap::Bitmap;
use crate::draw::draw;
use crate::figure_error::FigureError;
use crate::font::Typeface;
use crate::layout::lay_out;
use crate::pen::Pen;
use crate::spec::Figure;
use crate::style::{DOTS_PER_INCH, UNITS_PER_INCH, UNITS_PER_MM};

/// Drawing units across one printed dot.
const UNITS_PER_DOT: usize = UNITS_PER_INCH as usize / DOTS_PER_INCH as usize;

fn drawing_error<E: std::error::Error + Send + Sync + 'static>(
    error: DrawingErrorKind<E>,
) -> FigureError {
    FigureError::Drawing(Box::new(error))
}

impl Figure {
    /// Returns the figure as SVG, sized in millimetres, with title and caption as `<title>` and `<desc>`. Text stays
    /// text.
    ///
    /// ```
    /// use plotting::{Axis, Dash, Figure, Ink, Key, Panel, Series, Width};
    ///
    /// let curve = vec![(0.0, 0.9), (1.0, 0.6), (2.0, 0.4)];
    /// let figure = Figure {
    ///     name: "friction".to_owned(),
    ///     title: "Friction against amplitude".to_owned(),
    ///     caption: "Three points of a falling curve.".to_owned(),
    ///     width: Width::Column,
    ///     columns: 1,
    ///     panel_height_mm: 40.0,
    ///     footnote: None,
    ///     key: Key::InPanels,
    ///     panels: vec![Panel {
    ///         series: vec![Series::line(Ink::Blue, Dash::Solid, curve).with_name("measured")],
    ///         ..Panel::new(Axis::linear("Amplitude (µm)"), Axis::linear("μ").from_zero())
    ///     }],
    /// };
    /// let svg = figure.to_svg()?;
    /// assert!(svg.contains("width=\"85mm\""));
    /// assert!(svg.contains("<desc>Three points of a falling curve.</desc>"));
    /// # Ok::<(), plotting::FigureError>(())
    /// ```
    ///
    /// # Errors
    /// If the drawing library fails.
    pub fn to_svg(&self) -> Result<String, FigureError> {
        let typeface = Typeface::load()?;
        let layout = lay_out(self, &typeface);
        let mut drawing = String::new();
        let mut svg = SVGBackend::with_string(&mut drawing, layout.size);
        draw(self, &layout, &mut Pen(&mut svg)).map_err(drawing_error)?;
        drop(svg);

        let (width, height) = layout.size;
        let body = drawing.split_once('\n').map_or("", |(_, body)| body);
        let mut text = String::new();
        let _ = write!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}mm\" height=\"{:.2}mm\" viewBox=\"0 0 {width} {height}\" \
             role=\"img\">\n<title>{}</title>\n<desc>{}</desc>\n\
             <style>polyline{{stroke-linejoin:round;stroke-linecap:round}}</style>\n{body}",
            self.width.mm(),
            f64::from(height) / UNITS_PER_MM,
            escaping::xml_text(&self.title),
            escaping::xml_text(&self.caption),
        );
        Ok(text)
    }

    /// Returns the figure as PNG at 300 dpi, with title and caption as text chunks.
    ///
    /// # Errors
    /// If the drawing library or the encoder fails.
    pub fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        let typeface = Typeface::load()?;
        let mut layout = lay_out(self, &typeface);
        let dots = |units: u32| (units as usize).div_ceil(UNITS_PER_DOT);
        let (columns, rows) = (dots(layout.size.0), dots(layout.size.1));
        layout.size = (
            (columns * UNITS_PER_DOT) as u32,
            (rows * UNITS_PER_DOT) as u32,
        );
        let mut fine_pixels = vec![0u8; 3 * columns * rows * UNITS_PER_DOT.pow(2)];
        let mut bitmap = Bitmap::new(&mut fine_pixels, layout.size, &typeface);
        draw(self, &layout, &mut Pen(&mut bitmap)).map_err(drawing_error)?;
        drop(bitmap);
        self.encode(columns, &average(&fine_pixels, columns, rows))
    }

    fn encode(&self, columns: usize, pixels: &[u8]) -> Result<Vec<u8>, FigureError> {
        let rows = pixels.len() / (3 * columns);
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, columns as u32, rows as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let per_metre = (f64::from(DOTS_PER_INCH) / 0.0254).round() as u32;
        encoder.set_pixel_dims(Some(png::PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: png::Unit::Meter,
        }));
        encoder.add_itxt_chunk("Title".to_owned(), self.title.clone())?;
        encoder.add_itxt_chunk("Description".to_owned(), self.caption.clone())?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(pixels)?;
        writer.finish()?;
        Ok(bytes)
    }
}

/// Returns the printed dots, each the mean of the drawing units in it.
fn average(fine_pixels: &[u8], columns: usize, rows: usize) -> Vec<u8> {
    let stride = 3 * columns * UNITS_PER_DOT;
    let count = UNITS_PER_DOT.pow(2) as u32;
    let mut dots = Vec::with_capacity(3 * columns * rows);
    for lines in fine_pixels.chunks_exact(stride * UNITS_PER_DOT) {
        for column in 0..columns {
            for channel in 0..3 {
                let sum: u32 = (0..UNITS_PER_DOT)
                    .flat_map(|line| {
                        (0..UNITS_PER_DOT).map(move |dot_column| {
                            line * stride + 3 * (column * UNITS_PER_DOT + dot_column) + channel
                        })
                    })
                    .map(|index| u32::from(lines[index]))
                    .sum();
                dots.push(((sum + count / 2) / count) as u8);
            }
        }
    }
    dots
}
