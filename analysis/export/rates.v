(* ---- Rates: V falls at least as fast as exp (- 2 a t), in discrete time as r^(2 t); a, or r, is p / q ---- *)

Definition between (n : nat) (P now : list (list Z)) (low high : list term) (N M : Z) : bool :=
  (0 <? N)%Z && nonneg n (bilinear P now now ++ low ++ times (- N) (squares now)) &&
  nonneg n (times M (squares now) ++ times (-1) (bilinear P now now ++ high)).
Definition decays_in_time (n : nat) (P now next : list (list Z)) (low high turn S : list term) (p q N M : Z) : bool :=
  (0 <? q)%Z && between n P now low high N M &&
  nonneg n (times (- q) (bilinear P now next ++ bilinear P next now ++ turn)
            ++ times (-2 * p) (bilinear P now now ++ if (0 <=? p)%Z then high else low) ++ times (- q) S).
Definition decays_by_steps (n : nat) (P now next : list (list Z)) (S : list term) (p q N M : Z) : bool :=
  (0 <? q)%Z && between n P now [] [] N M &&
  nonneg n (times (p * p) (bilinear P now now) ++ times (- (q * q)) (bilinear P next next) ++ times (- (p * p)) S).

Fixpoint square_sum (fs : list (list Z)) (z : list R) : R :=
  match fs with f :: fs' => dot f z * dot f z + square_sum fs' z | [] => 0 end.
Lemma value_squares : forall fs z, value (squares fs) z = square_sum fs z.
Proof. induction fs as [|f fs IH]; intro z; [reflexivity|]; cbn [squares map value square_sum]; fold (squares fs); rewrite IH; ring. Qed.

Lemma between_sound : forall n P now low high N M z J, between n P now low high N M = true -> length z = n ->
  value low z <= J <= value high z ->
  0 < IZR N /\ IZR N * value (squares now) z <= value (bilinear P now now) z + J /\
  value (bilinear P now now) z + J <= IZR M * value (squares now) z.
Proof.
  intros n P now low high N M z J H len inside; unfold between in H.
  rewrite !andb_true_iff, Z.ltb_lt in H; destruct H as [[pos A] B].
  pose proof (nonneg_sound n _ z A len) as C; pose proof (nonneg_sound n _ z B len) as D.
  rewrite !value_app, value_times, opp_IZR in C; rewrite !value_app, !value_times, !value_app in D.
  apply IZR_lt in pos; split; [exact pos|split; lra].
Qed.

(* V = x^T P x + J, where J lies between two forms, and has the derivative [turn], one of z. *)
Theorem in_time_at_rate : forall n P now next low high turn S p q N M (z : R -> list R) (J : R -> R),
  decays_in_time n P now next low high turn S p q N M = true ->
  (forall t, length (z t) = n) -> flows z now next ->
  (forall t, 0 < t -> value low (z t) <= J t) -> (forall t, 0 < t -> J t <= value high (z t)) ->
  (forall t, 0 < t -> derivable_pt_lim J t (value turn (z t))) -> (forall t, 0 < t -> 0 <= value S (z t)) ->
  forall s t, 0 < s -> s <= t ->
  square_sum now (z t) <= IZR M / IZR N * exp (- (2 * (IZR p / IZR q) * (t - s))) * square_sum now (z s).
Proof.
  intros n P now next low high turn S p q N M z J test len F above below DJ class s t Hs st; rewrite <- !value_squares.
  unfold decays_in_time in test; rewrite !andb_true_iff, Z.ltb_lt in test; destruct test as [[pos B] falls].
  apply IZR_lt in pos; set (a := IZR p / IZR q).
  set (v := fun t => value (bilinear P now now) (z t) + J t).
  set (v' := fun t => value (bilinear P now next) (z t) + value (bilinear P next now) (z t) + value turn (z t)).
  assert (slow : forall t, 0 < t -> v' t + 2 * a * v t <= 0).
  { intros u Hu; pose proof (nonneg_sound n _ (z u) falls (len u)) as L.
    rewrite !value_app, !value_times, !value_app, mult_IZR, opp_IZR in L; fold (v' u) in L.
    pose proof (class u Hu).
    assert (E : IZR q * (v' u + 2 * a * v u) = IZR q * v' u + 2 * IZR p * v u) by (unfold a; field; lra).
    assert (G : IZR p * J u <= IZR p * value (if (0 <=? p)%Z then high else low) (z u)).
    { pose proof (above u Hu); pose proof (below u Hu); destruct (Z.leb_spec 0 p) as [K|K].
      - apply IZR_le in K; apply Rmult_le_compat_l; assumption.
      - apply IZR_lt in K; apply Rmult_le_compat_neg_l; lra. }
    set (W := value (if (0 <=? p)%Z then high else low) (z u)) in *.
    apply (Rmult_le_reg_l (IZR q)); [exact pos|]; rewrite E; unfold v, v' in *; simpl in L; nra. }
  assert (D : forall u, 0 < u -> derivable_pt_lim (fun u => v u * exp (2 * a * u)) u
      (v' u * exp (2 * a * u) + v u * (2 * a * exp (2 * a * u)))).
  { intros u Hu; apply (derivable_pt_lim_mult v (fun u => exp (2 * a * u))).
    - apply (derivable_pt_lim_plus (fun u => value (bilinear P now now) (z u)) J); [now apply flow_bilinear|auto].
    - apply exp_flow. }
  assert (K : v t * exp (2 * a * t) <= v s * exp (2 * a * s)).
  { apply (nonincreasing _ _ D); [|exact Hs|exact st]; intros u Hu.
    pose proof (slow u Hu); pose proof (exp_pos (2 * a * u)); nra. }
  assert (side : forall u, 0 < u -> value low (z u) <= J u <= value high (z u)) by (intros u Hu; split; auto).
  destruct (between_sound n P now low high N M (z t) (J t) B (len t) (side t ltac:(lra))) as [Npos [T _]].
  destruct (between_sound n P now low high N M (z s) (J s) B (len s) (side s Hs)) as [_ [_ U]].
  fold (v t) in T; fold (v s) in U.
  replace (- (2 * a * (t - s))) with (2 * a * s + - (2 * a * t)) by ring; rewrite exp_plus, exp_Ropp.
  pose proof (exp_pos (2 * a * t)) as Et; pose proof (exp_pos (2 * a * s)) as Es.
  apply (Rmult_le_reg_r (IZR N * exp (2 * a * t))); [nra|].
  replace (IZR M / IZR N * (exp (2 * a * s) * / exp (2 * a * t)) * value (squares now) (z s) * (IZR N * exp (2 * a * t)))
    with (exp (2 * a * s) * (IZR M * value (squares now) (z s))) by (field; lra).
  apply Rle_trans with (v t * exp (2 * a * t)).
  { rewrite <- Rmult_assoc; apply Rmult_le_compat_r; lra. }
  apply Rle_trans with (1 := K); rewrite Rmult_comm; apply Rmult_le_compat_l; lra.
Qed.

Theorem by_steps_at_rate : forall n P now next S p q N M (z : nat -> list R),
  decays_by_steps n P now next S p q N M = true ->
  (forall t, length (z t) = n) -> (forall t, at_ now (z (Datatypes.S t)) = at_ next (z t)) ->
  (forall t, 0 <= value S (z t)) ->
  forall k t, square_sum now (z (k + t)%nat) <= IZR M / IZR N * (IZR p / IZR q) ^ (2 * k) * square_sum now (z t).
Proof.
  intros n P now next S p q N M z test len step class k t; rewrite <- !value_squares.
  unfold decays_by_steps in test; rewrite !andb_true_iff, Z.ltb_lt in test; destruct test as [[pos B] falls].
  apply IZR_lt in pos; set (r := IZR p / IZR q).
  set (v := fun t => value (bilinear P now now) (z t)).
  assert (next_v : forall u, v (Datatypes.S u) <= r ^ 2 * v u).
  { intro u; pose proof (nonneg_sound n _ (z u) falls (len u)) as L.
    rewrite !value_app, !value_times, !opp_IZR, !mult_IZR in L; fold (v u) in L.
    assert (E : value (bilinear P next next) (z u) = v (Datatypes.S u)).
    { unfold v; rewrite !value_bilinear, step; reflexivity. }
    rewrite E in L; pose proof (class u).
    assert (G : IZR q * IZR q * (r ^ 2 * v u) = IZR p * IZR p * v u) by (unfold r; field; lra).
    assert (0 <= IZR p * IZR p * value S (z u)) by (apply Rmult_le_pos; [nra|assumption]).
    apply (Rmult_le_reg_l (IZR q * IZR q)); [nra|]; rewrite G; lra. }
  assert (K : v (k + t)%nat <= r ^ (2 * k) * v t).
  { induction k as [|k IH]; [simpl; lra|].
    replace (2 * Datatypes.S k)%nat with (2 + 2 * k)%nat by lia; rewrite pow_add.
    apply Rle_trans with (1 := next_v (k + t)%nat).
    rewrite Rmult_assoc; apply Rmult_le_compat_l; [apply pow2_ge_0|exact IH]. }
  destruct (between_sound n P now [] [] N M (z (k + t)%nat) 0 B (len _) ltac:(cbn; lra)) as [Npos [T _]].
  destruct (between_sound n P now [] [] N M (z t) 0 B (len t) ltac:(cbn; lra)) as [_ [_ U]].
  rewrite Rplus_0_r in T, U; fold (v (k + t)%nat) in T; fold (v t) in U.
  assert (pr : 0 <= r ^ (2 * k)) by (rewrite pow_mult; apply pow_le, pow2_ge_0).
  apply (Rmult_le_reg_l (IZR N)); [exact Npos|]; apply Rle_trans with (1 := T).
  replace (IZR N * (IZR M / IZR N * r ^ (2 * k) * value (squares now) (z t)))
    with (r ^ (2 * k) * (IZR M * value (squares now) (z t))) by (field; lra).
  apply Rle_trans with (1 := K); now apply Rmult_le_compat_l.
Qed.
