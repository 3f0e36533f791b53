//! A file that is complete or absent, and its hash.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// A file that appears under its name once it is complete; until then, dropping it removes it.
pub struct AtomicFile {
    file: File,
    temporary: PathBuf,
    target: PathBuf,
    digest: Sha256,
    bytes: u64,
}

/// The hash of a file, in hexadecimal digits, and its size.
pub type Contents = (String, u64);

impl AtomicFile {
    /// Creates a temporary file, and the folder of its target if it is missing.
    ///
    /// # Errors
    ///
    /// If one cannot be created, or the file is there already.
    pub fn create(temporary: &Path, target: &Path) -> io::Result<AtomicFile> {
        if let Some(folder) = target.parent() {
            fs::create_dir_all(folder)?;
        }
        let file = OpenOptions::new().write(true).create_new(true).open(temporary)?;
        Ok(AtomicFile {
            file,
            temporary: temporary.into(),
            target: target.into(),
            digest: Sha256::new(),
            bytes: 0,
        })
    }

    /// Moves the file to its target; one that is there keeps its permissions.
    ///
    /// # Errors
    ///
    /// If that fails.
    pub fn finish(mut self) -> io::Result<Contents> {
        if let Ok(known) = fs::metadata(&self.target) {
            self.file.set_permissions(known.permissions())?;
        }
        fs::rename(&self.temporary, &self.target)?;
        self.temporary.clear();
        Ok((hexadecimal(&self.digest.finalize_reset()), self.bytes))
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.digest.update(&bytes[..count]);
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if !self.temporary.as_os_str().is_empty() {
            // The error that led here is the one to report.
            drop(fs::remove_file(&self.temporary));
        }
    }
}

/// Returns bytes in hexadecimal digits.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::Write;

    use super::AtomicFile;

    #[test]
    fn a_file_is_complete_or_absent() {
        let folder = std::env::temp_dir().join(format!("rtcli-file-{}", std::process::id()));
        let (temporary, target) = (folder.join("a.tmp"), folder.join("a.txt"));
        let mut given_up = AtomicFile::create(&temporary, &target).unwrap();
        given_up.write_all(b"ab").unwrap();
        assert!(AtomicFile::create(&temporary, &target).is_err());
        drop(given_up);
        assert!(!temporary.exists() && !target.exists());

        let mut file = AtomicFile::create(&temporary, &target).unwrap();
        file.write_all(b"abc").unwrap();
        let (sha256, bytes) = file.finish().unwrap();
        assert_eq!((&sha256[..8], bytes), ("ba7816bf", 3)); // FIPS 180-4
        assert_eq!(fs::read(&target).unwrap(), b"abc");
        assert!(!temporary.exists());
        fs::remove_dir_all(folder).unwrap();
    }
}
