-- A trainee may have longer for a task to mark pops, as for an assignment.
CREATE TABLE segment_extensions (
    school_id BLOB NOT NULL,
    task_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    days INTEGER NOT NULL CHECK (days BETWEEN 1 AND 366),
    due_at INTEGER NOT NULL,
    PRIMARY KEY (task_id, person_id),
    FOREIGN KEY (school_id, task_id) REFERENCES segment_tasks (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX segment_extensions_by_due ON segment_extensions (due_at);
