//! Line, block and braille characters as rectangles in a cell of 8 × 16.

/// Width and height of a cell.
pub(super) const CELL: (u32, u32) = (8, 16);

/// A filled rectangle: left, top, width, height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

fn tile(x: u32, y: u32, width: u32, height: u32) -> Tile {
    Tile {
        x,
        y,
        width,
        height,
    }
}

/// Returns the tiles of a drawing character, and the eighths of ink in them; `None` for any other character.
pub(super) fn tiles(character: char) -> Option<(Vec<Tile>, u16)> {
    let (width, height) = CELL;
    let code = u32::from(character);
    let solid = |tiles| Some((tiles, 8));
    match character {
        '▀' => solid(vec![tile(0, 0, width, 8)]),
        '▁'..='█' => {
            let half_eighths = 2 * (code - 0x2580);
            solid(vec![tile(0, height - half_eighths, width, half_eighths)])
        }
        '▉'..='▏' => solid(vec![tile(0, 0, 0x2590 - code, height)]),
        '▐' => solid(vec![tile(4, 0, 4, height)]),
        '░' | '▒' | '▓' => {
            let eighths = [2, 4, 6][(code - 0x2591) as usize];
            Some((vec![tile(0, 0, width, height)], eighths))
        }
        '▔' => solid(vec![tile(0, 0, width, 2)]),
        '▕' => solid(vec![tile(7, 0, 1, height)]),
        '⠀'..='⣿' => solid(dots(code - 0x2800)),
        '─'..='╿' => arms(character).map(|arms| (lines(arms), 8)),
        _ => None,
    }
}

/// Returns the dots of a braille character, dots 1 to 8 by bit.
fn dots(bits: u32) -> Vec<Tile> {
    const PLACES: [(u32, u32); 8] = [
        (1, 1),
        (1, 5),
        (1, 9),
        (5, 1),
        (5, 5),
        (5, 9),
        (1, 13),
        (5, 13),
    ];
    let raised = PLACES
        .iter()
        .enumerate()
        .filter(|(i, _)| bits >> i & 1 == 1);
    raised.map(|(_, &(x, y))| tile(x, y, 2, 2)).collect()
}

/// Returns the widths of the lines from a cell's centre: left, right, up, down; `None` for other characters.
fn arms(character: char) -> Option<[u32; 4]> {
    Some(match character {
        '─' => [1, 1, 0, 0],
        '━' => [2, 2, 0, 0],
        '│' => [0, 0, 1, 1],
        '┃' => [0, 0, 2, 2],
        '┌' | '╭' => [0, 1, 0, 1],
        '┐' | '╮' => [1, 0, 0, 1],
        '└' | '╰' => [0, 1, 1, 0],
        '┘' | '╯' => [1, 0, 1, 0],
        '├' => [0, 1, 1, 1],
        '┤' => [1, 0, 1, 1],
        '┬' => [1, 1, 0, 1],
        '┴' => [1, 1, 1, 0],
        '┼' => [1, 1, 1, 1],
        '╴' => [1, 0, 0, 0],
        '╵' => [0, 0, 1, 0],
        '╶' => [0, 1, 0, 0],
        '╷' => [0, 0, 0, 1],
        '╸' => [2, 0, 0, 0],
        '╺' => [0, 2, 0, 0],
        _ => return None,
    })
}

fn lines([left, right, up, down]: [u32; 4]) -> Vec<Tile> {
    let (width, height) = CELL;
    let (middle, centre) = (width / 2 - 1, height / 2 - 1);
    let row_weight = left.max(right).max(1);
    let column_weight = up.max(down).max(1);
    let mut strokes = Vec::new();
    match (left > 0, right > 0) {
        (true, true) => strokes.push(tile(0, centre, width, row_weight)),
        (true, false) => strokes.push(tile(0, centre, middle + column_weight, row_weight)),
        (false, true) => strokes.push(tile(middle, centre, width - middle, row_weight)),
        (false, false) => {}
    }
    match (up > 0, down > 0) {
        (true, true) => strokes.push(tile(middle, 0, column_weight, height)),
        (true, false) => strokes.push(tile(middle, 0, column_weight, centre + row_weight)),
        (false, true) => strokes.push(tile(middle, centre, column_weight, height - centre)),
        (false, false) => {}
    }
    strokes
}
