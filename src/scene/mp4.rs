//! H.264 in mp4, by `re_mp4` (the container) and `openh264` (the video); its luma.

use std::path::Path;

use super::{Scene, SceneError};

#[cfg(not(feature = "mp4"))]
pub(super) fn open(path: &Path, _asked: Option<f64>) -> Result<Box<dyn Scene>, SceneError> {
    Err(SceneError::NoMp4 { path: path.into() })
}

#[cfg(feature = "mp4")]
pub(super) fn open(path: &Path, asked: Option<f64>) -> Result<Box<dyn Scene>, SceneError> {
    Ok(Box::new(h264::H264::new(path, asked)?))
}

#[cfg(feature = "mp4")]
mod h264 {
    use std::{
        collections::VecDeque,
        fs::File,
        io::{BufReader, Read, Seek, SeekFrom},
        path::{Path, PathBuf},
    };

    use openh264::{
        decoder::{DecodeOptions, DecodedYUV, Decoder, Flush},
        formats::YUVSource,
    };
    use re_mp4::{Mp4, Sample, StsdBoxContent, TrackKind};

    use crate::{
        guard::guarded,
        plane::{Plane, Size},
        scene::{Frame, Scene, SceneError, light, rate::Rate},
    };

    /// The largest sample (one coded picture) that is read: 64 MiB.
    const LARGEST_SAMPLE: u64 = 1 << 26;

    /// A clip being decoded.
    pub(super) struct H264 {
        path: PathBuf,
        file: BufReader<File>,
        decoder: Decoder,
        /// Coded pictures still to be read, in the order of the file.
        samples: std::vec::IntoIter<Sample>,
        /// Bytes of the length before each unit.
        length_bytes: usize,
        /// Decoded pictures still to be given, in the order of time.
        ready: VecDeque<Plane<f64>>,
        flushed: bool,
        size: Size,
        rate: Rate,
        count: u64,
        next: u64,
    }

    impl H264 {
        pub fn new(path: &Path, asked: Option<f64>) -> Result<Self, SceneError> {
            let wrong = |what: String| SceneError::Mp4 {
                path: path.into(),
                what,
            };
            let mut file = light::open_file(path)?;
            let bytes = file
                .get_ref()
                .metadata()
                .map_err(|cause| SceneError::unreadable(path, cause))?
                .len();
            // `re_mp4` 0.5 panics on some damaged tables; a damaged file is an error here.
            let mp4 = guarded(|| Mp4::read(&mut file, bytes))
                .ok_or_else(|| wrong("its tables are damaged".into()))?
                .map_err(|cause| wrong(format!("its tables are damaged: {cause}")))?;
            let track = mp4
                .tracks()
                .values()
                .find(|track| track.kind == Some(TrackKind::Video))
                .ok_or_else(|| wrong("it has no video track of a known kind".into()))?;
            let StsdBoxContent::Avc1(avc) = &track.trak(&mp4).mdia.minf.stbl.stsd.contents else {
                let codec = track.codec_string(&mp4);
                let codec = codec.unwrap_or_else(|| "unknown".into());
                return Err(wrong(format!("its video is {codec}, not H.264")));
            };
            let samples = track.samples.clone();
            let count = samples.len() as u64;
            let found = match asked {
                Some(_) => None,
                None => even_rate(path, &samples)?,
            };
            let rate = match count {
                0 => {
                    return Err(SceneError::Empty {
                        path: path.into(),
                        missing: "frame",
                    });
                }
                1 => Rate::asked_or_assumed(asked),
                _ => Rate::asked_or_found(asked, found, path)?,
            };
            let mut decoder =
                Decoder::new().map_err(|e| wrong(format!("no H.264 decoder: {e}")))?;
            let mut parameters = Vec::new();
            let config = &avc.avcc;
            for unit in config
                .sequence_parameter_sets
                .iter()
                .chain(&config.picture_parameter_sets)
            {
                push_unit(&mut parameters, &unit.bytes);
            }
            decoder
                .decode_with_options(&parameters, no_flush())
                .map_err(|e| wrong(format!("its H.264 parameters cannot be used: {e}")))?;
            let mut clip = Self {
                path: path.into(),
                file,
                decoder,
                samples: samples.into_iter(),
                length_bytes: usize::from(config.length_size_minus_one & 3) + 1,
                ready: VecDeque::new(),
                flushed: false,
                size: Size::new(0, 0),
                rate,
                count,
                next: 0,
            };
            // The size is that of the first decoded picture: the container's may be scaled.
            clip.fill()?;
            let Some(first) = clip.ready.front() else {
                return Err(clip.wrong("no picture could be decoded"));
            };
            clip.size = Size::of(first);
            Ok(clip)
        }

        fn wrong(&self, what: impl Into<String>) -> SceneError {
            SceneError::Mp4 {
                path: self.path.clone(),
                what: what.into(),
            }
        }

        /// Decodes until a picture is ready or the clip is over.
        ///
        /// Pictures come out in the order of time only if nothing is flushed before the end:
        /// B-frames wait in the decoder for the pictures that they lie between.
        fn fill(&mut self) -> Result<(), SceneError> {
            while self.ready.is_empty() && !self.flushed {
                if let Some(sample) = self.samples.next() {
                    let coded = self.read(&sample)?;
                    let decoded = self.decoder.decode_with_options(&coded, no_flush());
                    match decoded {
                        Ok(Some(picture)) => {
                            let light = luma(&self.path, self.next, &picture)?;
                            self.ready.push_back(light);
                        }
                        Ok(None) => {}
                        Err(e) => {
                            let id = sample.id;
                            return Err(self.wrong(format!("sample {id} cannot be decoded: {e}")));
                        }
                    }
                } else {
                    self.flushed = true;
                    match self.decoder.flush_remaining() {
                        Ok(pictures) => {
                            for picture in pictures {
                                self.ready.push_back(luma(&self.path, self.next, &picture)?);
                            }
                        }
                        Err(e) => {
                            return Err(
                                self.wrong(format!("its last frames cannot be decoded: {e}"))
                            );
                        }
                    }
                }
            }
            Ok(())
        }

        /// One coded picture, its units marked by start codes as the decoder wants them.
        fn read(&mut self, sample: &Sample) -> Result<Vec<u8>, SceneError> {
            if sample.size > LARGEST_SAMPLE {
                return Err(self.wrong(format!(
                    "sample {} has {} bytes, expected at most {LARGEST_SAMPLE}",
                    sample.id, sample.size
                )));
            }
            let mut bytes = Vec::new();
            self.file
                .seek(SeekFrom::Start(sample.offset))
                .and_then(|_| (&mut self.file).take(sample.size).read_to_end(&mut bytes))
                .map_err(|cause| SceneError::unreadable(&self.path, cause))?;
            if (bytes.len() as u64) < sample.size {
                return Err(SceneError::Truncated {
                    path: self.path.clone(),
                    frame: u64::from(sample.id),
                    got: bytes.len() as u64,
                    want: sample.size,
                });
            }
            let mut coded = Vec::with_capacity(bytes.len() + 16);
            let mut rest = bytes.as_slice();
            while !rest.is_empty() {
                let unit = rest
                    .split_at_checked(self.length_bytes)
                    .map(|(length, after)| {
                        let length = length.iter().fold(0, |all, b| all << 8 | usize::from(*b));
                        after.split_at_checked(length)
                    });
                let Some(Some((unit, after))) = unit else {
                    return Err(self.wrong(format!("sample {} has a damaged unit", sample.id)));
                };
                push_unit(&mut coded, unit);
                rest = after;
            }
            Ok(coded)
        }
    }

    impl Scene for H264 {
        fn size(&self) -> Size {
            self.size
        }
        fn fps(&self) -> f64 {
            self.rate.fps
        }
        fn fps_is_assumed(&self) -> bool {
            self.rate.assumed
        }
        fn frames(&self) -> Option<u64> {
            Some(self.count)
        }
        fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
            self.fill()?;
            let index = self.next;
            let Some(light) = self.ready.pop_front() else {
                if index == self.count {
                    return Ok(None);
                }
                let count = self.count;
                return Err(self.wrong(format!(
                    "only {index} of its {count} frames could be decoded"
                )));
            };
            if Size::of(&light) != self.size {
                return Err(SceneError::OddSize {
                    path: self.path.clone(),
                    frame: index,
                    got: Size::of(&light),
                    want: self.size,
                });
            }
            self.next += 1;
            Ok(Some(Frame {
                index,
                seconds: self.rate.seconds(index),
                light,
            }))
        }
    }

    fn no_flush() -> DecodeOptions {
        DecodeOptions::new().flush_after_decode(Flush::NoFlush)
    }

    fn push_unit(coded: &mut Vec<u8>, unit: &[u8]) {
        coded.extend([0, 0, 0, 1]);
        coded.extend(unit);
    }

    /// The luma of a decoded picture, as coded.
    fn luma(path: &Path, frame: u64, picture: &DecodedYUV<'_>) -> Result<Plane<f64>, SceneError> {
        let (width, height) = picture.dimensions();
        let size = light::checked_size(path, height, width)?;
        let rows = picture.y().chunks(picture.strides().0.max(1)).take(height);
        let numbers = rows
            .flat_map(|row| row.iter().take(width))
            .map(|&b| f64::from(b));
        light::plane(size, numbers.collect()).ok_or_else(|| SceneError::Mp4 {
            path: path.into(),
            what: format!("frame {frame} was decoded to too few pixels"),
        })
    }

    /// The rate of evenly spaced frames, from the time at which each is shown.
    fn even_rate(path: &Path, samples: &[Sample]) -> Result<Option<f64>, SceneError> {
        let mut times: Vec<i64> = samples.iter().map(|s| s.composition_timestamp).collect();
        times.sort_unstable();
        let (Some(first), Some(last), Some(sample)) =
            (times.first(), times.last(), samples.first())
        else {
            return Ok(None);
        };
        let (unit, steps) = (sample.timescale as f64, times.len() - 1);
        if steps == 0 || sample.timescale == 0 || first == last {
            return Ok(None);
        }
        let step = (last - first) as f64 / steps as f64;
        for (frame, time) in times.iter().enumerate() {
            let (got, want) = ((time - first) as f64, frame as f64 * step);
            // Times are whole units, so each may be half a unit off, and the ends as well.
            if (got - want).abs() > 1.0 {
                return Err(SceneError::Uneven {
                    path: path.into(),
                    frame: frame as u64,
                    got: got / unit,
                    want: want / unit,
                });
            }
        }
        Ok(Some(unit / step))
    }
}
