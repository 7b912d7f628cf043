-- Why one attempt was graded again: once this stood in the audit log alone, where no text can be made unreadable. The log keeps its hash.
CREATE TABLE regrade_reasons (
    score_id BLOB PRIMARY KEY NOT NULL REFERENCES scores (id),
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    reason TEXT NOT NULL CHECK (length(trim(reason)) > 0),
    made_by BLOB, -- NULL: on the command line
    made_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX regrade_reasons_by_session ON regrade_reasons (school_id, session_id);
CREATE INDEX regrade_reasons_by_maker ON regrade_reasons (school_id, made_by);

CREATE TRIGGER regrade_reasons_never_change BEFORE UPDATE ON regrade_reasons
WHEN NOT (NEW.reason = '[erased]' AND NEW.score_id = OLD.score_id AND NEW.school_id = OLD.school_id
    AND NEW.session_id = OLD.session_id AND NEW.made_by IS OLD.made_by AND NEW.made_at = OLD.made_at)
BEGIN SELECT RAISE(ABORT, 'a reason never changes: another grade has another'); END;
CREATE TRIGGER regrade_reasons_never_go BEFORE DELETE ON regrade_reasons
BEGIN SELECT RAISE(ABORT, 'a reason is never deleted'); END;
