-- Attempts that were frozen for an exam board. `head` is everything of the signed file before the recording: the manifest, its
-- signature, documents, scores, proofs and ratings. The recording follows from where attempts are stored, and the padding of a tar.
-- A file never changes; its head is emptied when the person is erased.
CREATE TABLE exam_files (
    id UUID PRIMARY KEY NOT NULL,
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    person_id UUID NOT NULL, -- who made the attempt
    made_by UUID NOT NULL,
    made_at BIGINT NOT NULL,
    sha256 TEXT COLLATE "C" NOT NULL CHECK (length(sha256) = 64), -- of the whole file
    bytes BIGINT NOT NULL CHECK (bytes > 0), -- of the whole file
    head BYTEA NOT NULL,
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
);

CREATE INDEX exam_files_by_session ON exam_files (school_id, session_id, made_at);
CREATE INDEX exam_files_by_person ON exam_files (school_id, person_id);
CREATE INDEX exam_files_by_maker ON exam_files (school_id, made_by);

CREATE TRIGGER exam_files_never_change BEFORE UPDATE ON exam_files
FOR EACH ROW WHEN (NOT (length(NEW.head) = 0 AND NEW.id = OLD.id AND NEW.school_id = OLD.school_id
    AND NEW.session_id = OLD.session_id AND NEW.person_id = OLD.person_id AND NEW.made_by = OLD.made_by
    AND NEW.made_at = OLD.made_at AND NEW.sha256 = OLD.sha256 AND NEW.bytes = OLD.bytes))
EXECUTE FUNCTION refuse('an exam file never changes: another one is frozen');
CREATE TRIGGER exam_files_never_go BEFORE DELETE ON exam_files
FOR EACH ROW EXECUTE FUNCTION refuse('an exam file is never deleted');
CREATE TRIGGER exam_files_never_go_all_at_once BEFORE TRUNCATE ON exam_files
EXECUTE FUNCTION refuse('an exam file is never deleted');
