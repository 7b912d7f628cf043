-- The latest act of somebody, and what became of something, in order: without `seq` in it an index names whose rows there are, and a server of
-- databases may rather walk the whole log from its end.
DROP INDEX audit_log_by_actor;
DROP INDEX audit_log_by_object;
CREATE INDEX audit_log_by_actor ON audit_log (actor, seq);
CREATE INDEX audit_log_by_object ON audit_log (object, seq);
