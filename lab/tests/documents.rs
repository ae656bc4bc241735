//! Documents: options of the commands that this workspace has.

use crate::common::Folder;
use crate::common::documented::check_named_options;

#[test]
fn options_of_measurements_and_faults_that_documents_name_exist() {
    let (named, helps) = check_named_options(&Folder::new(), |command| ["bench", "torture"].contains(&command));
    assert!(named > 10 && helps > 5, "{named} options of {helps} commands");
}
