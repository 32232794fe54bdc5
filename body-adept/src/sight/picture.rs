//! Picture files: PNG and binary PPM.

use std::io::{BufRead, Read};

use pschema_vision::image::{RgbImage, SIDE_PX_MAX};

/// Longest header line of a PPM, in bytes.
const HEADER_BYTES_MAX: u64 = 256;

/// Reads a binary PPM (P6, 8 bits a channel).
pub(super) fn ppm(from: &mut impl BufRead) -> Result<RgbImage, String> {
    let mut numbers = Vec::new();
    if token(from)? != "P6" {
        return Err("not a binary PPM (P6)".to_owned());
    }
    while numbers.len() < 3 {
        let text = token(from)?;
        numbers.push(text.parse::<usize>().map_err(|_| format!("{text:?} in the header of a PPM"))?);
    }
    let [width, height, most] = numbers.as_slice() else { return Err("half a header".to_owned()) };
    if *most != 255 || !(1..=SIDE_PX_MAX).contains(width) || !(1..=SIDE_PX_MAX).contains(height) {
        return Err(format!(
            "a PPM of {width}x{height}, maximum {most}: at most {SIDE_PX_MAX} px a side, maximum 255"
        ));
    }
    let mut bytes = vec![0; width * height * 3];
    from.read_exact(&mut bytes).map_err(|error| format!("the picture breaks off: {error}"))?;
    RgbImage::from_rgb_bytes(*width, *height, &bytes).map_err(|error| error.to_string())
}

/// The next word of a header; comments run from `#` to the end of the line.
fn token(from: &mut impl BufRead) -> Result<String, String> {
    let mut word = String::new();
    let mut comment = false;
    for byte in from.by_ref().take(HEADER_BYTES_MAX).bytes() {
        let byte = byte.map_err(|error| error.to_string())?;
        match byte {
            b'\n' => {
                comment = false;
                if !word.is_empty() {
                    return Ok(word);
                }
            }
            _ if comment => {}
            b'#' => comment = true,
            byte if byte.is_ascii_whitespace() => {
                if !word.is_empty() {
                    return Ok(word);
                }
            }
            byte => word.push(char::from(byte)),
        }
    }
    Err("the header of a PPM has no end".to_owned())
}

/// Reads a PNG of 8 bits a channel, with or without colour or transparency.
pub(super) fn png(from: impl BufRead + std::io::Seek) -> Result<RgbImage, String> {
    let mut decoder = png::Decoder::new(from);
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    if width > SIDE_PX_MAX || height > SIDE_PX_MAX {
        return Err(format!("a PNG of {width}x{height}: at most {SIDE_PX_MAX} px a side"));
    }
    let size = reader.output_buffer_size().ok_or("a PNG too large to hold")?;
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(|error| error.to_string())?;
    let channels = frame.color_type.samples();
    let mut image = RgbImage::new(width, height).map_err(|error| error.to_string())?;
    for (pixel, from) in image.pixels_mut().iter_mut().zip(bytes.chunks_exact(channels)) {
        *pixel = match from {
            [red, green, blue, ..] => [*red, *green, *blue],
            [grey, ..] => [*grey; 3],
            [] => [0; 3],
        };
    }
    Ok(image)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_ppm_with_comments_is_read() {
        let mut bytes = b"P6\n# a camera\n2 # wide\n1\n255\n".to_vec();
        bytes.extend([1, 2, 3, 10, 35, 6]);
        let image = ppm(&mut bytes.as_slice()).unwrap();
        assert_eq!((image.width_px(), image.pixels()), (2, &[[1, 2, 3], [10, 35, 6]][..]));
        for cut in 0..bytes.len() {
            assert!(ppm(&mut &bytes[..cut]).is_err(), "{cut} bytes");
        }
        assert!(ppm(&mut &b"P6 90000 90000 255\n"[..]).unwrap_err().contains("px a side"));
    }

    proptest! {
        #[test]
        fn hostile_bytes_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            prop_assert!(png(std::io::Cursor::new(&bytes)).is_err());
            let _image = ppm(&mut bytes.as_slice());
            let mut headed = b"P6\n4 4\n255\n".to_vec();
            headed.extend(&bytes);
            prop_assert_eq!(ppm(&mut headed.as_slice()).is_ok(), bytes.len() >= 48);
        }
    }
}
