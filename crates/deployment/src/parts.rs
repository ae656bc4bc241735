//! Parts of a deployment's file that belong to services.
//!
//! Each service declares its own keys and checks them. The executable puts the parts together: it knows all services.
//! A program without some services ignores their tables.

use settings::{KeyTable, SettingsError};

use crate::Deployment;

/// Keys of services in a deployment's file.
pub trait Parts: Default {
    /// Tables whose keys are tables of the file.
    fn tables(&mut self) -> Vec<&mut dyn KeyTable>;

    /// Checks the values against the rest of the deployment, and adds the facts that other processes need.
    ///
    /// # Errors
    /// A key by its path in the file, with its value and a remedy.
    fn join(&self, deployment: &mut Deployment) -> Result<(), SettingsError>;
}

/// No service: their tables are ignored.
impl Parts for () {
    fn tables(&mut self) -> Vec<&mut dyn KeyTable> {
        Vec::new()
    }

    fn join(&self, _: &mut Deployment) -> Result<(), SettingsError> {
        Ok(())
    }
}
