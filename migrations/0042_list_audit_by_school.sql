-- What an administrator reads: the acts of their school, the latest first.
CREATE INDEX audit_log_by_school ON audit_log (school_id, seq);
