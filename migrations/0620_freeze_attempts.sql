-- Attempts that were frozen for an exam board. `head` is everything of the signed file before the recording: the manifest, its
-- signature, documents, scores, proofs and ratings. The recording follows from where attempts are stored, and the padding of a tar.
-- A file never changes; its head is emptied when the person is erased.
CREATE TABLE exam_files (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    person_id BLOB NOT NULL, -- who made the attempt
    made_by BLOB NOT NULL,
    made_at INTEGER NOT NULL,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64), -- of the whole file
    bytes INTEGER NOT NULL CHECK (bytes > 0), -- of the whole file
    head BLOB NOT NULL,
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX exam_files_by_session ON exam_files (school_id, session_id, made_at);
CREATE INDEX exam_files_by_person ON exam_files (school_id, person_id);
CREATE INDEX exam_files_by_maker ON exam_files (school_id, made_by);

CREATE TRIGGER exam_files_never_change BEFORE UPDATE ON exam_files
WHEN NOT (length(NEW.head) = 0 AND NEW.id = OLD.id AND NEW.school_id = OLD.school_id AND NEW.session_id = OLD.session_id
    AND NEW.person_id = OLD.person_id AND NEW.made_by = OLD.made_by AND NEW.made_at = OLD.made_at
    AND NEW.sha256 = OLD.sha256 AND NEW.bytes = OLD.bytes)
BEGIN SELECT RAISE(ABORT, 'an exam file never changes: another one is frozen'); END;
CREATE TRIGGER exam_files_never_go BEFORE DELETE ON exam_files
BEGIN SELECT RAISE(ABORT, 'an exam file is never deleted'); END;
