(* ---- A contraction has a fixed point ---- *)

Lemma fixed_point : forall D (T : (nat -> R) -> nat -> R) rho, 0 <= rho ->
  (forall y y' M, 0 <= M -> (forall l, (l < D)%nat -> Rabs (y l) <= rho) -> (forall l, (l < D)%nat -> Rabs (y' l) <= rho) ->
    (forall l, (l < D)%nat -> Rabs (y l - y' l) <= M) -> forall l, (l < D)%nat -> Rabs (T y l - T y' l) <= M / 2) ->
  (forall l, (l < D)%nat -> Rabs (T (fun _ => 0) l) <= rho / 2) ->
  exists y, (forall l, (l < D)%nat -> Rabs (y l) <= rho) /\ forall l, (l < D)%nat -> T y l = y l.
Proof.
  intros D T rho r0 C Z; set (it := fix it (k : nat) : nat -> R := match k with O => fun _ => 0 | S j => T (it j) end).
  assert (B : forall k l, (l < D)%nat -> Rabs (it k l) <= rho).
  { induction k as [|k IH]; intros l L; [cbn; rewrite Rabs_R0; lra|]; cbn [it].
    replace (T (it k) l) with ((T (it k) l - T (fun _ => 0) l) + T (fun _ => 0) l) by ring.
    apply Rle_trans with (1 := Rabs_triang _ _); specialize (Z l L).
    assert (Rabs (T (it k) l - T (fun _ => 0) l) <= rho / 2); [|lra].
    apply C; auto; intros; [rewrite Rabs_R0; lra|rewrite Rminus_0_r; auto]. }
  assert (P : forall N, 0 <= rho / 2 ^ N) by (intro N; apply Rmult_le_pos; [lra|left; apply Rinv_0_lt_compat, pow_lt; lra]).
  assert (H : forall N, rho / 2 ^ S N = rho / 2 ^ N / 2) by (intro N; cbn [pow]; field; apply pow_nonzero; lra).
  assert (S0 : forall N k l, (l < D)%nat -> Rabs (it (N + k)%nat l - it N l) <= rho / 2 ^ N).
  { induction N as [|N IH]; intros k l L; cbn [Nat.add].
    - cbn [it pow]; rewrite Rminus_0_r; specialize (B k l L); lra.
    - cbn [it]; rewrite H; apply C; auto. }
  assert (Cy : forall l, (l < D)%nat -> Cauchy_crit (fun k => it k l)).
  { intros l L eps epos; destruct (cv_pow_half rho (eps / 2) ltac:(lra)) as [N HN]; specialize (HN N ltac:(lia)).
    unfold R_dist in HN; rewrite Rminus_0_r, Rabs_right in HN by (apply Rle_ge, P); exists N; intros a b a0 b0; unfold R_dist.
    pose proof (S0 N (a - N)%nat l L) as Sa; pose proof (S0 N (b - N)%nat l L) as Sb; replace (N + (a - N))%nat with a in Sa by lia; replace (N + (b - N))%nat with b in Sb by lia.
    replace (it a l - it b l) with ((it a l - it N l) - (it b l - it N l)) by ring.
    apply Rle_lt_trans with (1 := Rabs_triang _ _); rewrite Rabs_Ropp; lra. }
  set (y := fun l => match lt_dec l D with left L => proj1_sig (R_complete _ (Cy l L)) | right _ => 0 end).
  assert (Ly : forall l, (l < D)%nat -> Un_cv (fun k => it k l) (y l)).
  { intros l L; unfold y; destruct (lt_dec l D) as [L'|]; [exact (proj2_sig (R_complete _ (Cy l L')))|contradiction]. }
  assert (Ny : forall N l, (l < D)%nat -> Rabs (y l - it N l) <= rho / 2 ^ N).
  { intros N l L; apply le_epsilon; intros eps epos; destruct (Ly l L eps epos) as [K HK]; specialize (HK (N + K)%nat ltac:(lia)).
    unfold R_dist in HK; pose proof (S0 N K l L); replace (y l - it N l) with (- (it (N + K)%nat l - y l) + (it (N + K)%nat l - it N l)) by ring.
    apply Rle_trans with (1 := Rabs_triang _ _); rewrite Rabs_Ropp; lra. }
  assert (By : forall l, (l < D)%nat -> Rabs (y l) <= rho).
  { intros l L; specialize (Ny O l L); cbn [it pow] in Ny; rewrite Rminus_0_r in Ny; lra. }
  exists y; split; [exact By|]; intros l L; apply Rminus_diag_uniq; destruct (Req_dec (T y l - y l) 0) as [E|E]; [exact E|exfalso].
  apply Rabs_pos_lt in E; destruct (cv_pow_half rho _ E) as [N HN]; specialize (HN N ltac:(lia)).
  unfold R_dist in HN; rewrite Rminus_0_r, Rabs_right in HN by (apply Rle_ge, P).
  pose proof (C y (it N) (rho / 2 ^ N) (P N) By (B N) (Ny N) l L) as C1; pose proof (Ny (S N) l L) as N1; rewrite H in N1; cbn [it] in N1.
  replace (T y l - y l) with ((T y l - T (it N) l) - (y l - T (it N) l)) in HN by ring.
  pose proof (Rabs_triang (T y l - T (it N) l) (- (y l - T (it N) l))) as Tr; rewrite Rabs_Ropp in Tr; unfold Rminus in *; lra.
Qed.

(* ---- All solutions of a linear flow, by those from s times the unit vectors ---- *)

Definition spot (n j : nat) (s : Z) : list Z := map (fun k => if (k =? j)%nat then s else 0%Z) (seq 0 n).
Fixpoint blend (s : R) (Phi : nat -> nat -> R -> R) (j : nat) (X : list R) (k : nat) (t : R) : R :=
  match X with [] => 0 | x :: r => x / s * Phi j k t + blend s Phi (S j) r k t end.
Lemma dot_zeros : forall r m, dot r (listed m (fun _ => 0)) = 0.
Proof. intros r m; unfold listed; generalize (seq 0 m); induction r as [|a r IH]; intros [|k l]; cbn [map dot]; try ring; rewrite IH; ring. Qed.
Lemma blend_solves : forall n d A s Phi, IZR d <> 0 -> (forall i, solves n d A (Phi i)) -> forall X j, solves n d A (blend s Phi j X).
Proof.
  intros n d A s Phi d0 H; induction X as [|x X IH]; intros j k t K; cbn [blend].
  - rewrite dot_zeros; apply (derivable_same (fun _ => 0) _ t 0); [reflexivity|field; exact d0|apply derivable_pt_lim_const].
  - apply (derivable_same (fun t => x / s * Phi j k t + blend s Phi (S j) X k t) _ t
      (x / s * (dot (nth k A []) (listed n (fun i => Phi j i t)) / IZR d) + dot (nth k A []) (listed n (fun i => blend s Phi (S j) X i t)) / IZR d));
      [reflexivity|rewrite dot_listed; unfold Rdiv; ring|].
    apply (derivable_pt_lim_plus (fun t => x / s * Phi j k t) (blend s Phi (S j) X k)); [|now apply IH].
    apply (derivable_pt_lim_scal (Phi j k)); now apply H.
Qed.
Lemma blend_start : forall s Phi k, s <> 0 -> (forall j, Phi j k 0 = if (k =? j)%nat then s else 0) -> forall X j,
  blend s Phi j X k 0 = if (j <=? k)%nat then nth (k - j) X 0 else 0.
Proof.
  intros s Phi k s0 H; induction X as [|x X IH]; intro j; cbn [blend]; [destruct (j <=? k)%nat, (k - j)%nat; reflexivity|].
  rewrite H, IH; destruct (Nat.eqb_spec k j) as [->|ne].
  - rewrite Nat.leb_refl, Nat.sub_diag; cbn [nth]; rewrite (proj2 (Nat.leb_gt (S j) j)) by lia; field; exact s0.
  - destruct (Nat.leb_spec j k) as [L|L].
    + rewrite (proj2 (Nat.leb_le (S j) k)) by lia; replace (k - j)%nat with (S (k - S j)) by lia; cbn [nth]; unfold Rdiv; ring.
    + rewrite (proj2 (Nat.leb_gt (S j) k)) by lia; unfold Rdiv; ring.
Qed.
Lemma blend_less : forall s Phi k t X X' j, length X = length X' ->
  blend s Phi j X k t - blend s Phi j X' k t = blend s Phi j (lcomb 1 (-1) X X') k t.
Proof.
  intros s Phi k t; induction X as [|x X IH]; intros [|x' X'] j L; try discriminate; cbn [blend lcomb]; [ring|].
  rewrite <- IH by (cbn in L; lia); unfold Rdiv; ring.
Qed.
Lemma blend_near : forall s Phi k t eta M, 0 < s -> 0 <= eta -> 0 <= M -> forall cols X j,
  (forall i, (i < length cols)%nat -> Rabs (Phi (j + i)%nat k t - IZR (nth k (nth i cols []) 0%Z)) <= eta) ->
  (forall i, Rabs (nth i X 0) <= M) -> (forall i, (length cols <= i)%nat -> nth i X 0 = 0) ->
  Rabs (s * blend s Phi j X k t - dot (map (fun c => nth k c 0%Z) cols) X) <= INR (length cols) * (M * eta).
Proof.
  intros s Phi k t eta M s0 e0 M0; induction cols as [|c cols IH]; intros X j H B Z.
  - assert (E : blend s Phi j X k t = 0).
    { clear H B; revert j; induction X as [|x X IH]; intro j; cbn [blend]; [reflexivity|].
      rewrite IH by (intros i _; exact (Z (S i) ltac:(cbn; lia))); specialize (Z O ltac:(cbn; lia)); cbn in Z; rewrite Z; unfold Rdiv; ring. }
    rewrite E; cbn [map dot length INR]; rewrite Rmult_0_r, Rminus_0_r, Rabs_R0; lra.
  - destruct X as [|x X]; [cbn [blend map dot]; rewrite Rmult_0_r, Rminus_0_r, Rabs_R0; apply Rmult_le_pos; [apply pos_INR|now apply Rmult_le_pos]|].
    cbn [blend map dot length]; rewrite S_INR.
    specialize (IH X (S j) (fun i I => eq_ind _ (fun a => Rabs (Phi a k t - _) <= eta) (H (S i) ltac:(cbn; lia)) _ (Nat.add_succ_r j i))
      (fun i => B (S i)) (fun i I => Z (S i) ltac:(cbn; lia))).
    specialize (H O ltac:(cbn; lia)); rewrite Nat.add_0_r in H; specialize (B O); cbn [nth] in H, B.
    replace (s * (x / s * Phi j k t + blend s Phi (S j) X k t) - (IZR (nth k c 0%Z) * x + dot (map (fun c => nth k c 0%Z) cols) X))
      with (x * (Phi j k t - IZR (nth k c 0%Z)) + (s * blend s Phi (S j) X k t - dot (map (fun c => nth k c 0%Z) cols) X)) by (field; lra).
    apply Rle_trans with (1 := Rabs_triang _ _); rewrite Rabs_mult.
    assert (Rabs x * Rabs (Phi j k t - IZR (nth k c 0%Z)) <= M * eta) by (apply Rmult_le_compat; auto using Rabs_pos); lra.
Qed.

Lemma dot_size : forall r z M, 0 <= M -> (forall k, Rabs (nth k z 0) <= M) -> Rabs (dot r z) <= IZR (row_size r) * M.
Proof.
  induction r as [|a r IH]; intros [|x z] M M0 H; cbn [dot row_size]; try (rewrite Rabs_R0; lra).
  - rewrite Rabs_R0; apply Rmult_le_pos; [exact (row_size_nonneg (a :: r))|exact M0].
  - specialize (IH z M M0 (fun k => H (S k))); specialize (H O); cbn [nth] in H.
    apply Rle_trans with (1 := Rabs_triang _ _); rewrite plus_IZR, abs_IZR, Rabs_mult; pose proof (Rabs_pos (IZR a)); nra.
Qed.
Lemma dot_snoc : forall r z v x, length r = length z -> dot (r ++ [v]) (z ++ [x]) = dot r z + IZR v * x.
Proof. induction r as [|a r IH]; intros [|y z] v x L; try discriminate; cbn [app dot]; [ring|]; rewrite IH by (cbn in L; lia); ring. Qed.
Lemma listed_S : forall n f, listed (S n) f = listed n f ++ [f n].
Proof. intros; unfold listed; rewrite seq_S, map_app; reflexivity. Qed.
